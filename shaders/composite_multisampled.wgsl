// composite.wgsl for a depth with several samples and a color that is their mean, black for the sky: at
// the edges the sky shows through, mixed as light. Not in GLSL ES.

@group(1) @binding(0) var scene_color: texture_2d<f32>;
@group(1) @binding(1) var scene_depth: texture_multisampled_2d<f32>;

// A sample whose distance differs by less takes the air of the last one.
const SAME_AIR: f32 = 0.002;

@fragment
fn composite_fragment(in: ScreenVertex) -> @location(0) vec4<f32> {
    let pixel = scene_pixel(in);
    let samples = textureNumSamples(scene_depth);
    var path = AerialPath(vec4<f32>(0.0, 0.0, 0.0, 0.0), vec3<f32>(0.0, 0.0, 0.0));
    var transmittance = vec3<f32>(0.0, 0.0, 0.0);
    var inscatter = vec3<f32>(0.0, 0.0, 0.0);
    var objects = 0.0;
    var last_km = -1.0;
    for (var i = 0u; i < samples; i = i + 1u) {
        let depth = textureLoad(scene_depth, pixel, i32(i)).x;
        if (is_object(depth)) {
            let ray = scene_ray(in, depth);
            if (abs(ray.w - last_km) > SAME_AIR * ray.w) {
                path = aerial_path(sky.altitude_km, ray.xyz, ray.w);
                last_km = ray.w;
            }
            transmittance = transmittance + path.transmittance.xyz;
            inscatter = inscatter + path.inscatter;
            objects = objects + 1.0;
        }
    }
    if (objects < 0.5) {
        discard;
    }
    // the color is the mean over all samples already
    let color = textureLoad(scene_color, pixel, 0).xyz / sky.scene_exposure;
    let light = transmittance / objects * color + inscatter / f32(samples);
    return displayed(light + sky_share(in, objects / f32(samples)), in.position.xy);
}

@fragment
fn scene_fragment(in: ScreenVertex) -> @location(0) vec4<f32> {
    let pixel = scene_pixel(in);
    let samples = textureNumSamples(scene_depth);
    var objects = 0.0;
    for (var i = 0u; i < samples; i = i + 1u) {
        objects = objects + select(0.0, 1.0, is_object(textureLoad(scene_depth, pixel, i32(i)).x));
    }
    if (objects < 0.5) {
        discard;
    }
    let color = textureLoad(scene_color, pixel, 0).xyz / sky.scene_exposure;
    return displayed(color + sky_share(in, objects / f32(samples)), in.position.xy);
}

// Light of the sky, or of the ground below it, in what objects leave free of a pixel.
fn sky_share(in: ScreenVertex, covered: f32) -> vec3<f32> {
    if (covered > 0.999) {
        return vec3<f32>(0.0, 0.0, 0.0);
    }
    var direction = normalize(in.ray);
    if (view.projection > 0.5) {
        direction = to_local(panorama_ray(in.clip).xyz);
    }
    var light: vec3<f32>;
    if (is_sky(direction)) {
        light = sky_light(direction) + sun_disc(direction);
    } else {
        light = ground_light(direction);
    }
    return (1.0 - covered) * light;
}
