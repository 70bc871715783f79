// CIE overcast sky (Moon & Spencer 1942), luminance only; twin of CieOvercast in
// crates/sky-baselines/src/cie.rs. baseline[0].w: the zenith's luminance.

fn baseline_xyz(direction: vec3<f32>) -> vec3<f32> {
    if (direction.z < -1e-6) {
        return vec3<f32>(0.0);
    }
    // D65
    return baseline[0].w * (1.0 + 2.0 * direction.z) / 3.0 * vec3<f32>(0.9504559, 1.0, 1.0890578);
}
