// Aerial perspective over a finished scene: color and depth in, displayed color out. The sky's pixels
// are left as they are.

// scene light in linear sRGB [cd/m2]
@group(2) @binding(0) var scene_color: texture_2d<f32>;
// depth in clip space, or where view.kind.w is 1 the distance [km], 0 for the sky
@group(2) @binding(1) var scene_depth: texture_2d<f32>;

@fragment
fn composite_fragment(in: ScreenVertex) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(in.position.xy - view.viewport.xy);
    let depth = textureLoad(scene_depth, pixel, 0).x;
    var direction: vec3<f32>;
    var distance_km = depth;
    if (view.kind.w > 0.5) {
        if (depth <= 0.0) {
            discard;
        }
        if (view.kind.x > 0.5) {
            direction = to_local(panorama_ray(in.clip).xyz);
        } else {
            direction = normalize(in.ray);
        }
    } else {
        if (depth == view.dome.w) {
            discard;
        }
        let place = view.clip_to_world * vec4<f32>(in.clip, depth, 1.0);
        let world = place.xyz / place.w;
        direction = to_local(world);
        distance_km = length(world) * view.viewport.z;
    }
    let color = textureLoad(scene_color, pixel, 0).xyz;
    let path = aerial_path(sky.place.w, direction, distance_km);
    return displayed(path.transmittance.xyz * color + path.inscatter, in.position.xy, sky.display);
}

// The scene as it is, displayed like the sky.
@fragment
fn scene_fragment(in: ScreenVertex) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(in.position.xy - view.viewport.xy);
    let depth = textureLoad(scene_depth, pixel, 0).x;
    if (depth == select(view.dome.w, 0.0, view.kind.w > 0.5)) {
        discard;
    }
    return displayed(textureLoad(scene_color, pixel, 0).xyz, in.position.xy, sky.display);
}
