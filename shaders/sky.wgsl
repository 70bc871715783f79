// Entry points of the sky: full screen (formula or baked texture) and dome.

struct ViewUniform {
    // from clip space (x, y, depth, 1) to world directions; translation left out
    clip_to_world: mat4x4<f32>,
    // from world directions to clip space
    world_to_clip: mat4x4<f32>,
    // 0 perspective, 1 fisheye, 2 equirectangular; depth in clip space for rays; aspect; 0
    kind: vec4<f32>,
    // first pixel of the viewport, kilometers of a unit of the world, 0
    viewport: vec4<f32>,
    // rings and spokes of the dome, azimuth where its seam lies, depth of the far plane
    dome: vec4<f32>,
}

@group(1) @binding(0) var<uniform> view: ViewUniform;

struct ScreenVertex {
    @builtin(position) position: vec4<f32>,
    @location(0) clip: vec2<f32>,
    @location(1) ray: vec3<f32>,
}

fn ray_of(clip: vec2<f32>) -> vec3<f32> {
    let world = view.clip_to_world * vec4<f32>(clip, view.kind.y, 1.0);
    return world.xyz / world.w;
}

@vertex
fn screen_vertex(@builtin(vertex_index) index: u32) -> ScreenVertex {
    let clip = vec2<f32>(f32((index << 1u) & 2u) * 2.0 - 1.0, f32(index & 2u) * 2.0 - 1.0);
    var out: ScreenVertex;
    out.position = vec4<f32>(clip, view.dome.w, 1.0);
    out.clip = clip;
    out.ray = ray_of(clip);
    return out;
}

// Directions of pictures that no matrix makes; w is 0 outside the picture.
fn panorama_ray(clip: vec2<f32>) -> vec4<f32> {
    var direction: vec3<f32>;
    var inside = 1.0;
    if (view.kind.x < 1.5) {
        let disc = vec2<f32>(clip.x * max(view.kind.z, 1.0), clip.y / min(view.kind.z, 1.0));
        let radius = length(disc);
        inside = select(0.0, 1.0, radius <= 1.0);
        let zenith = radius * 1.57079633;
        let s = sin(zenith) / max(radius, 1e-6);
        direction = vec3<f32>(disc.x * s, disc.y * s, cos(zenith));
    } else {
        let azimuth = clip.x * 3.14159265;
        let elevation = clip.y * 1.57079633;
        direction = vec3<f32>(sin(azimuth) * cos(elevation), cos(azimuth) * cos(elevation), sin(elevation));
    }
    // right, forward and up of the view in the world are the matrix's columns
    let world = view.clip_to_world * vec4<f32>(direction, 0.0);
    return vec4<f32>(world.xyz, inside);
}

// Light from a unit vector in the local frame, without the sun's disc.
fn sky_and_ground(direction: vec3<f32>) -> vec3<f32> {
    if (sky.debug.x > 0.5) {
        return outside_domain(direction);
    }
    if (direction.z < sky.place.z - 2e-7) {
        let distance = distance_to_ground(sky.place.w, direction.z);
        let path = aerial_path(sky.place.w, direction, distance);
        return path.transmittance.xyz * sky.ground.xyz + path.inscatter;
    }
    let angles = angle_from_sun(direction, sky.place.xy);
    return linear_srgb_from_yxy(sky_yxy(direction.z, angles.x, angles.y));
}

// The same with the sun's disc.
fn light_from(direction: vec3<f32>) -> vec3<f32> {
    let light = sky_and_ground(direction);
    let mu = direction.x * sky.place.x + direction.z * sky.place.y;
    if (mu > 0.99998 && direction.z >= sky.place.z - 2e-7) {
        return light + sun_disc(angle_from_sun(direction, sky.place.xy).z, mu, direction.z);
    }
    return light;
}

// Stripes that nobody takes for a sky.
fn outside_domain(direction: vec3<f32>) -> vec3<f32> {
    let stripe = select(0.1, 1.0, fract((direction.x + direction.y + direction.z) * 8.0) < 0.5);
    return vec3<f32>(stripe, 0.0, stripe) / max(sky.display.x, 1e-9);
}

@fragment
fn sky_fragment(in: ScreenVertex) -> @location(0) vec4<f32> {
    return displayed(light_from(to_local(in.ray)), in.position.xy, sky.display);
}

@fragment
fn sky_panorama(in: ScreenVertex) -> @location(0) vec4<f32> {
    let ray = panorama_ray(in.clip);
    if (ray.w < 0.5) {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    return displayed(light_from(to_local(ray.xyz)), in.position.xy, sky.display);
}

@fragment
fn floor_fragment(in: ScreenVertex) -> @location(0) vec4<f32> {
    return vec4<f32>(0.25, 0.5, 0.75, 1.0);
}
