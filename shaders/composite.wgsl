// Aerial perspective over a finished scene: color and depth in, displayed color out. The sky's pixels
// are left as they are.

// scene light in linear sRGB [cd/m2] times sky.scene_exposure
@group(1) @binding(0) var scene_color: texture_2d<f32>;
// depth in clip space, or where view.depth_is_distance is 1 the distance [km], 0 for the sky
@group(1) @binding(1) var scene_depth: texture_2d<f32>;

@fragment
fn composite_fragment(in: ScreenVertex) -> @location(0) vec4<f32> {
    let pixel = scene_pixel(in);
    let depth = textureLoad(scene_depth, pixel, 0).x;
    if (!is_object(depth)) {
        discard;
    }
    let ray = scene_ray(in, depth);
    let object = textureLoad(scene_color, pixel, 0).xyz / sky.scene_exposure;
    return displayed(behind_air(ray.xyz, ray.w, object), in.position.xy);
}

// The scene as it is, displayed like the sky.
@fragment
fn scene_fragment(in: ScreenVertex) -> @location(0) vec4<f32> {
    let pixel = scene_pixel(in);
    if (!is_object(textureLoad(scene_depth, pixel, 0).x)) {
        discard;
    }
    return displayed(textureLoad(scene_color, pixel, 0).xyz / sky.scene_exposure, in.position.xy);
}
