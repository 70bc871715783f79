// The report's way: a dome whose corners are colored by the vertex shader, and blended between them.
// The mesh is made from the vertex number: rings from the zenith to the horizon and on to the nadir.

struct DomeVertex {
    @builtin(position) position: vec4<f32>,
    @location(0) light: vec3<f32>,
    @location(1) direction: vec3<f32>,
}

@vertex
fn dome_vertex(@builtin(vertex_index) index: u32) -> DomeVertex {
    let rings = u32(view.dome_rings);
    let spokes = u32(view.dome_spokes);
    let quad = index / 6u;
    let corner = index % 6u;
    let ring = quad / spokes;
    let outer = select(0u, 1u, corner == 1u || corner == 2u || corner == 4u);
    let next = select(0u, 1u, corner == 2u || corner == 4u || corner == 5u);
    let horizon = angle_from(sqrt(max(1.0 - sky.cos_horizon * sky.cos_horizon, 0.0)), sky.cos_horizon);
    let is_ground = ring >= rings;
    var zenith: f32;
    if (is_ground) {
        let share = f32(ring - rings + outer) / f32(GROUND_RINGS);
        zenith = horizon + share * share * (3.14159265 - horizon);
    } else {
        zenith = horizon * f32(ring + outer) / f32(rings);
    }
    let turn = f32(quad % spokes + next) / f32(spokes);
    let azimuth = view.dome_seam_azimuth + turn * 6.28318531;
    let direction = vec3<f32>(sin(zenith) * cos(azimuth), sin(zenith) * sin(azimuth), cos(zenith));
    // a corner on the horizon belongs to the sky or to the ground, as its quad does
    var lit = direction;
    if (is_ground) {
        lit.z = min(lit.z, sky.cos_horizon - 1e-6);
    } else {
        lit.z = max(lit.z, sky.cos_horizon);
    }
    var out: DomeVertex;
    if (is_ground) {
        out.light = ground_light(lit);
    } else {
        out.light = sky_light(lit);
    }
    out.direction = direction;
    let world = sky.local_x * direction.x + sky.local_y * direction.y + sky.local_z * direction.z;
    if (view.projection < 0.5) {
        let clip = view.world_to_clip * vec4<f32>(world, 0.0);
        out.position = vec4<f32>(clip.xy, view.far_depth * clip.w, clip.w);
    } else {
        if (view.projection < 1.5) {
            // right and forward of the view; from the azimuth, for the nadir itself has none
            let level = sky.local_x * cos(azimuth) + sky.local_y * sin(azimuth);
            let seen = (view.world_to_clip * vec4<f32>(level, 0.0)).xy;
            let disc = normalize(seen) * (zenith / 1.57079633);
            out.position = vec4<f32>(disc.x / max(view.aspect, 1.0), disc.y * min(view.aspect, 1.0), view.far_depth, 1.0);
        } else {
            // azimuths grow to the left
            out.position = vec4<f32>(1.0 - turn * 2.0, 1.0 - zenith / 1.57079633, view.far_depth, 1.0);
        }
    }
    return out;
}

@fragment
fn dome_fragment(in: DomeVertex) -> @location(0) vec4<f32> {
    let direction = normalize(in.direction);
    if (view.projection > 0.5 && view.projection < 1.5 && direction.z < 0.0) {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    return displayed(in.light + sun_disc(direction), in.position.xy);
}
