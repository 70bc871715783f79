// The numbers of the frame that every pixel reads, from the uniform. flat.wgsl has another way.

fn coefficient(k: u32) -> vec4<f32> {
    return sky.coefficients[k];
}

// Sine and cosine of the sun's zenith angle, cosine of the horizon's, sine of the sun's radius.
fn place_of_sun() -> vec4<f32> {
    return vec4<f32>(sky.place.xyz, sky.ground.w);
}

fn upper_limb() -> vec4<f32> {
    return sky.sun_upper;
}

fn lower_limb() -> vec4<f32> {
    return sky.sun_lower;
}

fn baked_scale() -> f32 {
    return sky.debug.z;
}
