// The view, the full-screen triangle, and the light of sky and ground.

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
    // in the local frame, of any length
    @location(1) ray: vec3<f32>,
}

fn ray_of(clip: vec2<f32>) -> vec3<f32> {
    let world = view.clip_to_world * vec4<f32>(clip, view.kind.y, 1.0);
    return world.xyz / world.w;
}

fn screen_corner(index: u32) -> ScreenVertex {
    let clip = vec2<f32>(f32((index << 1u) & 2u) * 2.0 - 1.0, f32(index & 2u) * 2.0 - 1.0);
    var out: ScreenVertex;
    out.position = vec4<f32>(clip, view.dome.w, 1.0);
    out.clip = clip;
    let ray = ray_of(clip);
    out.ray = vec3<f32>(dot(sky.local_x.xyz, ray), dot(sky.local_y.xyz, ray), dot(sky.local_z.xyz, ray));
    return out;
}

@vertex
fn screen_vertex(@builtin(vertex_index) index: u32) -> ScreenVertex {
    return screen_corner(index);
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

// Light from a unit vector in the local frame at or above the horizon, without the sun's disc.
fn sky_light(direction: vec3<f32>) -> vec3<f32> {
    let angles = angle_from_sun(direction, sky.place.xy);
    let light = linear_srgb_from_yxy(sky_yxy(direction.z, angles.x, angles.y));
    return select(light, outside_domain(direction), sky.debug.x > 0.5);
}

// Light from below the horizon: the ground through the air.
fn ground_light(direction: vec3<f32>) -> vec3<f32> {
    let distance = distance_to_ground(sky.place.w, direction.z);
    let path = aerial_path(sky.place.w, direction, distance);
    let light = path.transmittance.xyz * sky.ground.xyz + path.inscatter;
    return select(light, outside_domain(direction), sky.debug.x > 0.5);
}

fn is_sky(direction: vec3<f32>) -> bool {
    return direction.z >= place_of_sun().z - 2e-7;
}

// Stripes that nobody takes for a sky.
fn outside_domain(direction: vec3<f32>) -> vec3<f32> {
    let stripe = select(0.1, 1.0, fract((direction.x + direction.y + direction.z) * 8.0) < 0.5);
    return vec3<f32>(stripe, 0.0, stripe) / max(sky.display.x, 1e-9);
}
