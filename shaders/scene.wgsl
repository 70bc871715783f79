// Where the pixel of a finished scene is.

fn scene_pixel(in: ScreenVertex) -> vec2<i32> {
    return vec2<i32>(in.position.xy - view.viewport_origin);
}

// Whether a depth is of an object, not of the sky.
fn is_object(depth: f32) -> bool {
    if (view.depth_is_distance > 0.5) {
        return depth > 0.0;
    }
    return depth != view.far_depth;
}

// Local direction and distance [km] of a depth.
fn scene_ray(in: ScreenVertex, depth: f32) -> vec4<f32> {
    if (view.depth_is_distance > 0.5) {
        if (view.projection > 0.5) {
            return vec4<f32>(to_local(panorama_ray(in.clip).xyz), depth);
        }
        return vec4<f32>(normalize(in.ray), depth);
    }
    let place = view.clip_to_world * vec4<f32>(in.clip, depth, 1.0);
    let world = place.xyz / place.w;
    if (view.rays_are_parallel > 0.5) {
        let along = dot(world, normalize(view.ray_center));
        return vec4<f32>(normalize(in.ray), max(along, 0.0) * view.km_per_unit);
    }
    return vec4<f32>(to_local(world), length(world) * view.km_per_unit);
}
