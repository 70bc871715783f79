// Hoffman & Preetham 2002; twin of crates/sky-baselines/src/hoffman.rs.
// baseline[0]: the sun's direction; [1]: Rayleigh scattering per km, w: 2 R H + H^2 of the layer;
// [2]: haze per km, w: R; [3]: the sun's irradiance at the ground over that outside, w: g;
// [4]-[6]: rows of XYZ from radiance.

struct Aerial {
    transmittance: vec3<f32>,
    // CIE XYZ, cd/m2
    in_scattered: vec3<f32>,
}

fn baseline_aerial(direction: vec3<f32>, distance_km: f32) -> Aerial {
    let rayleigh = baseline[1].xyz;
    let haze = baseline[2].xyz;
    let g = baseline[3].w;
    let cos_gamma = clamp(dot(direction, baseline[0].xyz), -1.0, 1.0);
    let denominator = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_gamma);
    let rayleigh_phase = 0.059683104 * (1.0 + cos_gamma * cos_gamma);
    let haze_phase = 0.079577472 * (1.0 - g * g) / (denominator * sqrt(denominator));
    let transmittance = exp(-(rayleigh + haze) * distance_km);
    let ratio = (rayleigh * rayleigh_phase + haze * haze_phase) / (rayleigh + haze)
        * baseline[3].xyz * (1.0 - transmittance);
    let xyz = vec3<f32>(
        dot(baseline[4].xyz, ratio),
        dot(baseline[5].xyz, ratio),
        dot(baseline[6].xyz, ratio),
    );
    return Aerial(transmittance, xyz);
}

fn baseline_xyz(direction: vec3<f32>) -> vec3<f32> {
    if (direction.z < -1e-6) {
        return vec3<f32>(0.0);
    }
    let rise = baseline[1].w;
    let along = baseline[2].w * direction.z;
    return baseline_aerial(direction, rise / (along + sqrt(along * along + rise))).in_scattered;
}
