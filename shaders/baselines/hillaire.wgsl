// Hillaire 2020; twin of HillaireFrame::xyz in crates/sky-baselines/src/hillaire.rs.
// baseline[0]: altitude, km; zenith angle of the horizon; largest value of the table, cd/m2.
// Texture: the sky view, 192 x 108, CIE XYZ as a share of the largest value.

const EARTH_RADIUS: f32 = 6371.0;
const WIDTH: f32 = 192.0;
const HEIGHT: f32 = 108.0;

fn baseline_xyz(direction: vec3<f32>) -> vec3<f32> {
    let sine = sqrt(max(1.0 - direction.z * direction.z, 0.0));
    let lowest = baseline[0].x
        - (EARTH_RADIUS + baseline[0].x) * direction.z * direction.z / (1.0 + sine);
    if (direction.z < 0.0 && lowest < -1e-3) {
        return vec3<f32>(0.0);
    }
    let level = length(direction.xy);
    let cos_azimuth = select(1.0, direction.x / max(level, 1e-6), level > 1e-6);
    let share = max(1.0 - atan2(level, direction.z) / baseline[0].y, 0.0);
    let x = sqrt(max(0.5 - 0.5 * cos_azimuth, 0.0));
    let y = 0.5 - 0.5 * sqrt(share);
    let place = vec2<f32>((x * (WIDTH - 1.0) + 0.5) / WIDTH, (y * (HEIGHT - 1.0) + 0.5) / HEIGHT);
    return baseline[0].z * textureSampleLevel(baseline_texture, baseline_sampler, place, 0.0).xyz;
}
