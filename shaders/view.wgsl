// The camera and the full-screen triangle. Twin: Camera::direction in crates/sky-gpu/src/camera.rs.

struct ScreenVertex {
    @builtin(position) position: vec4<f32>,
    @location(0) clip: vec2<f32>,
    // in the local frame, of any length
    @location(1) ray: vec3<f32>,
}

// World direction of a ray, of any length.
fn ray_of(clip: vec2<f32>) -> vec3<f32> {
    return view.ray_x * clip.x + view.ray_y * clip.y + view.ray_center;
}

fn screen_corner(index: u32) -> ScreenVertex {
    let clip = vec2<f32>(f32((index << 1u) & 2u) * 2.0 - 1.0, f32(index & 2u) * 2.0 - 1.0);
    var out: ScreenVertex;
    out.position = vec4<f32>(clip, view.far_depth, 1.0);
    out.clip = clip;
    let ray = ray_of(clip);
    out.ray = vec3<f32>(dot(sky.local_x, ray), dot(sky.local_y, ray), dot(sky.local_z, ray));
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
    if (view.projection < 1.5) {
        let disc = vec2<f32>(clip.x * max(view.aspect, 1.0), clip.y / min(view.aspect, 1.0));
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
