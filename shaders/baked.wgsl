// Full-screen skies: the formula at every pixel, or a small texture over azimuth from the sun and
// height over the horizon. The ground is of the texture in both.

@group(1) @binding(0) var baked_texture: texture_2d<f32>;
@group(1) @binding(1) var baked_sampler: sampler;

// Texel of a direction: across, the sine of half the azimuth from the sun; up, the root of the height
// over or under the horizon. Sky and ground never blend.
fn baked_from_direction(direction: vec3<f32>) -> vec2<f32> {
    let flat_squared = max(direction.x * direction.x + direction.y * direction.y, 1e-12);
    let across = sqrt(clamp(0.5 - 0.5 * direction.x * inverseSqrt(flat_squared), 0.0, 1.0));
    let cos_horizon = sky.cos_horizon;
    let height = direction.z - cos_horizon;
    let above = is_sky(direction);
    let whole = select(1.0 + cos_horizon, 1.0 - cos_horizon, above);
    let away = min(sqrt(abs(height) / whole), 1.0);
    let texels = select(1.0 - BAKED_GROUND, BAKED_HEIGHT - BAKED_GROUND - 1.0, above);
    let edge = BAKED_GROUND + select(-0.5, 0.5, above);
    return vec2<f32>(0.5 + across * (BAKED_WIDTH - 1.0), edge + away * texels);
}

// The inverse of baked_from_direction.
fn direction_from_baked(texel: vec2<f32>) -> vec3<f32> {
    let cos_horizon = sky.cos_horizon;
    let across = clamp((texel.x - 0.5) / (BAKED_WIDTH - 1.0), 0.0, 1.0);
    let cos_azimuth = 1.0 - 2.0 * across * across;
    let sin_azimuth = 2.0 * across * sqrt(max(1.0 - across * across, 0.0));
    var cosine: f32;
    if (texel.y < BAKED_GROUND) {
        let down = (BAKED_GROUND - 0.5 - texel.y) / (BAKED_GROUND - 1.0);
        // the highest ground texel lies just under the horizon
        cosine = cos_horizon - max(down * down * (1.0 + cos_horizon), 1e-6);
    } else {
        let up = (texel.y - BAKED_GROUND - 0.5) / (BAKED_HEIGHT - BAKED_GROUND - 1.0);
        cosine = cos_horizon + up * up * (1.0 - cos_horizon);
    }
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    return vec3<f32>(sine * cos_azimuth, sine * sin_azimuth, cosine);
}

@fragment
fn bake_sky(in: ScreenVertex) -> @location(0) vec4<f32> {
    return vec4<f32>(sky_light(direction_from_baked(in.position.xy)) * sky.baked_scale, 1.0);
}

@fragment
fn bake_ground(in: ScreenVertex) -> @location(0) vec4<f32> {
    return vec4<f32>(ground_light(direction_from_baked(in.position.xy)) * sky.baked_scale, 1.0);
}

fn baked_light(direction: vec3<f32>) -> vec3<f32> {
    let uv = baked_from_direction(direction) / vec2<f32>(BAKED_WIDTH, BAKED_HEIGHT);
    return textureSampleLevel(baked_texture, baked_sampler, uv, 0.0).xyz / sky.baked_scale;
}

// The formula for the sky, the texture for the ground.
fn light_from(direction: vec3<f32>) -> vec3<f32> {
    if (is_sky(direction)) {
        return sky_light(direction) + sun_disc(direction);
    }
    return baked_light(direction);
}

@fragment
fn sky_fragment(in: ScreenVertex) -> @location(0) vec4<f32> {
    return displayed(light_from(normalize(in.ray)), in.position.xy);
}

@fragment
fn sky_panorama(in: ScreenVertex) -> @location(0) vec4<f32> {
    let ray = panorama_ray(in.clip);
    let color = displayed(light_from(to_local(ray.xyz)), in.position.xy);
    return select(vec4<f32>(0.0, 0.0, 0.0, 1.0), color, ray.w > 0.5);
}

@fragment
fn baked_fragment(in: ScreenVertex) -> @location(0) vec4<f32> {
    let direction = normalize(in.ray);
    return displayed(baked_light(direction) + sun_disc(direction), in.position.xy);
}

@fragment
fn baked_panorama(in: ScreenVertex) -> @location(0) vec4<f32> {
    let ray = panorama_ray(in.clip);
    let direction = to_local(ray.xyz);
    let color = displayed(baked_light(direction) + sun_disc(direction), in.position.xy);
    return select(vec4<f32>(0.0, 0.0, 0.0, 1.0), color, ray.w > 0.5);
}
