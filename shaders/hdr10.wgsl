// For HDR10 targets: PQ, Rec.2020. Twin: hdr10 in crates/sky-core/src/hdr.rs.

fn displayed(light: vec3<f32>, pixel: vec2<f32>) -> vec4<f32> {
    let nits = rec2020_from_linear_srgb(light * sky.exposure) * sky.white_nits;
    return vec4<f32>(pq_encoded(rolled_off(nits, sky.peak_nits)) + dither(pixel) * sky.dither_step, 1.0);
}
