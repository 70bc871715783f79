// CIE clear sky (Kittler 1967), luminance only; twin of CieClear in crates/sky-baselines/src/cie.rs.
// baseline[0]: the sun's direction, and the zenith's luminance over the pattern's value there.

fn baseline_xyz(direction: vec3<f32>) -> vec3<f32> {
    if (direction.z < -1e-6) {
        return vec3<f32>(0.0);
    }
    let sun = baseline[0].xyz;
    let cos_gamma = clamp(dot(direction, sun), -1.0, 1.0);
    let gamma = atan2(length(cross(direction, sun)), cos_gamma);
    let indicatrix = 0.91 + 10.0 * exp(-3.0 * gamma) + 0.45 * cos_gamma * cos_gamma;
    let gradation = 1.0 - exp(-0.32 / max(direction.z, 1e-4));
    // D65
    return baseline[0].w * indicatrix * gradation * vec3<f32>(0.9504559, 1.0, 1.0890578);
}
