// For scRGB targets: linear, 1 is 80 cd/m2. Twin: scrgb in crates/sky-core/src/hdr.rs.

fn displayed(light: vec3<f32>, pixel: vec2<f32>) -> vec4<f32> {
    return vec4<f32>(rolled_off(light * sky.exposure * sky.white_nits, sky.peak_nits) / SCRGB_UNIT_NITS, 1.0);
}
