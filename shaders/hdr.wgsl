// From exposed light to an HDR display. Twin: crates/sky-core/src/hdr.rs.

// Light [cd/m2] rolled off below the display's peak.
fn rolled_off(nits: vec3<f32>, peak: f32) -> vec3<f32> {
    let start = SHOULDER * peak;
    let brightest = max(nits.x, max(nits.y, nits.z));
    if (brightest <= start) {
        return nits;
    }
    let room = peak - start;
    return nits * ((peak - room * room / (brightest - start + room)) / brightest);
}

// Rec.2020 from linear sRGB; colors outside it end on its edge.
fn rec2020_from_linear_srgb(rgb: vec3<f32>) -> vec3<f32> {
    return max(vec3<f32>(
        dot(vec3<f32>(0.6274039, 0.32928304, 0.043313066), rgb),
        dot(vec3<f32>(0.06909729, 0.9195404, 0.011362316), rgb),
        dot(vec3<f32>(0.01639144, 0.08801331, 0.89559525), rgb),
    ), vec3<f32>(0.0, 0.0, 0.0));
}

// The perceptual quantizer of light [cd/m2].
fn pq_encoded(nits: vec3<f32>) -> vec3<f32> {
    let y = pow(clamp(nits / 10000.0, vec3<f32>(0.0, 0.0, 0.0), vec3<f32>(1.0, 1.0, 1.0)),
        vec3<f32>(0.15930176, 0.15930176, 0.15930176));
    return pow((0.8359375 + 18.851562 * y) / (1.0 + 18.6875 * y), vec3<f32>(78.84375, 78.84375, 78.84375));
}
