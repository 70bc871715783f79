// Hosek & Wilkie 2012; twin of crates/sky-baselines/src/hosek.rs.
// baseline[0]: the sun's direction; [1]-[9]: the nine coefficients for red, green, blue;
// [10]: mean radiance, times 683 lm/W.

fn baseline_xyz(direction: vec3<f32>) -> vec3<f32> {
    if (direction.z < -1e-6) {
        return vec3<f32>(0.0);
    }
    let sun = baseline[0].xyz;
    let cos_gamma = clamp(dot(direction, sun), -1.0, 1.0);
    let gamma = atan2(length(cross(direction, sun)), cos_gamma);
    let cos_view = max(direction.z, 0.0);
    let cos_2 = cos_gamma * cos_gamma;
    let g = baseline[9].xyz;
    let base = 1.0 + g * g - 2.0 * g * cos_gamma;
    let chi = (1.0 + cos_2) / (base * sqrt(base));
    let gradation = 1.0 + baseline[1].xyz * exp(baseline[2].xyz / (cos_view + 0.01));
    let pattern = baseline[3].xyz + baseline[4].xyz * exp(baseline[5].xyz * gamma)
        + baseline[6].xyz * cos_2 + baseline[7].xyz * chi + baseline[8].xyz * sqrt(cos_view);
    let rgb = baseline[10].xyz * gradation * pattern;
    return vec3<f32>(
        dot(vec3<f32>(0.4123908, 0.3575843, 0.1804808), rgb),
        dot(vec3<f32>(0.2126390, 0.7151687, 0.0721923), rgb),
        dot(vec3<f32>(0.0193308, 0.1191948, 0.9505322), rgb),
    );
}
