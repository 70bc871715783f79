// Nielsen 2003, reading (a); twin of crates/sky-baselines/src/nielsen.rs.
// baseline[0]: the sun's direction, w: altitude, km; [1]: Rayleigh scattering per km, w: its zenith
// length, km; [2]: haze per km, w: its zenith length, km; [3]: the sun's irradiance over that
// outside, w: g; [4]-[6]: rows of XYZ from radiance, w of [4]: haziness.

struct Aerial {
    transmittance: vec3<f32>,
    // CIE XYZ, cd/m2
    in_scattered: vec3<f32>,
}

fn light(direction: vec3<f32>, air_km: f32, haze_km: f32) -> Aerial {
    let rayleigh = baseline[1].xyz;
    let haze = baseline[2].xyz;
    let g = baseline[3].w;
    let cos_gamma = clamp(dot(direction, baseline[0].xyz), -1.0, 1.0);
    let denominator = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_gamma);
    let rayleigh_phase = 0.059683104 * (1.0 + 0.5 * cos_gamma * cos_gamma);
    let haze_phase = 0.079577472 * (1.0 - g * g) / (denominator * sqrt(denominator));
    let transmittance = exp(-(rayleigh * air_km + haze * haze_km));
    let ratio = (rayleigh * rayleigh_phase + haze * haze_phase) / (rayleigh + haze)
        * baseline[3].xyz * (1.0 - transmittance);
    let xyz = vec3<f32>(
        dot(baseline[4].xyz, ratio),
        dot(baseline[5].xyz, ratio),
        dot(baseline[6].xyz, ratio),
    );
    return Aerial(transmittance, xyz);
}

// Mean of exp(-z/H) over a path that climbs by rise_km, times the path.
fn optical_length(distance_km: f32, rise_km: f32, altitude_km: f32, scale_km: f32) -> f32 {
    let delta = rise_km / scale_km;
    var mean = 1.0 - 0.5 * delta;
    if (abs(delta) > 1e-3) {
        mean = (1.0 - exp(-delta)) / delta;
    }
    return distance_km * exp(-altitude_km / scale_km) * mean;
}

fn baseline_aerial(direction: vec3<f32>, distance_km: f32) -> Aerial {
    let altitude = baseline[0].w;
    let rise = distance_km * direction.z;
    return light(
        direction,
        optical_length(distance_km, rise, altitude, 8.0),
        optical_length(distance_km, rise, altitude, 1.2),
    );
}

fn baseline_xyz(direction: vec3<f32>) -> vec3<f32> {
    // the sphere of the Earth
    let radius = 6371.0 + baseline[0].w;
    let sine_2 = 1.0 - direction.z * direction.z;
    let lowest = baseline[0].w - radius * direction.z * direction.z / (1.0 + sqrt(sine_2));
    if (direction.z < 0.0 && lowest < -1e-3) {
        return vec3<f32>(0.0);
    }
    let f = pow(clamp(direction.z, 0.001, 1.0), baseline[4].w);
    let horizon_km = (1.0 - f) * 190.0;
    return light(
        direction,
        mix(horizon_km, baseline[1].w, f),
        mix(horizon_km, baseline[2].w, f),
    ).in_scattered;
}
