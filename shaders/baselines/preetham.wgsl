// Preetham, Shirley, Smits 1999; twin of crates/sky-baselines/src/preetham.rs.
// baseline[0]: the sun's direction; [1]-[5]: A-E for Y, x, y; [6]: zenith value over F(0, sun).

fn baseline_xyz(direction: vec3<f32>) -> vec3<f32> {
    if (direction.z < -1e-6) {
        return vec3<f32>(0.0);
    }
    let sun = baseline[0].xyz;
    let cos_gamma = clamp(dot(direction, sun), -1.0, 1.0);
    let gamma = atan2(length(cross(direction, sun)), cos_gamma);
    let air_mass = 1.0 / max(direction.z, 1e-4);
    let gradation = 1.0 + baseline[1].xyz * exp(baseline[2].xyz * air_mass);
    let indicatrix = 1.0 + baseline[3].xyz * exp(baseline[4].xyz * gamma)
        + baseline[5].xyz * cos_gamma * cos_gamma;
    let yxy = baseline[6].xyz * gradation * indicatrix;
    return yxy.x / yxy.z * vec3<f32>(yxy.y, yxy.z, 1.0 - yxy.y - yxy.z);
}
