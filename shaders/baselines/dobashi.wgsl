// Dobashi et al. 2002; twin of crates/sky-baselines/src/dobashi.rs.
// baseline[0]: the sun's direction, w: altitude, km; [3]-[5]: rows of XYZ from radiance, w: g.
// Texture: four tables of 128 x 64 texels on top of each other: sunlight by the sun's cosine; by the
// view's cosine, light of a segment by air and by haze, times GAIN, and what passes it; rows are
// altitudes.

const EARTH_RADIUS: f32 = 6371.0;
const TOP: f32 = 100.0;
const PLANES_KM: f32 = 10.0;
const PLANES: i32 = 200;
const ANGLES: f32 = 128.0;
const ALTITUDES: f32 = 64.0;
const GAIN: f32 = 4096.0;

fn table(which: f32, cosine: f32, row: f32) -> vec3<f32> {
    let column = clamp((1.0 + 2.0 * sign(cosine) * sqrt(abs(cosine))) / 3.0, 0.0, 1.0);
    let place = vec2<f32>(
        (column * (ANGLES - 1.0) + 0.5) / ANGLES,
        (which * ALTITUDES + row * (ALTITUDES - 1.0) + 0.5) / (4.0 * ALTITUDES),
    );
    return textureSampleLevel(baseline_texture, baseline_sampler, place, 0.0).xyz;
}

fn baseline_xyz(direction: vec3<f32>) -> vec3<f32> {
    let eye = baseline[0].w;
    let start = EARTH_RADIUS + eye;
    let sine = sqrt(max(1.0 - direction.z * direction.z, 0.0));
    let lowest = eye - start * direction.z * direction.z / (1.0 + sine);
    if (direction.z < 0.0 && lowest < -1e-3) {
        return vec3<f32>(0.0);
    }
    let cos_gamma = clamp(dot(direction, baseline[0].xyz), -1.0, 1.0);
    let square = 1.0 + cos_gamma * cos_gamma;
    let g = baseline[3].w;
    let denominator = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_gamma);
    let air_phase = 0.059683104 / GAIN * square;
    let haze_phase = 0.11936621 / GAIN * (1.0 - g * g) / (2.0 + g * g) * square
        / (denominator * sqrt(denominator));
    var light = vec3<f32>(0.0);
    var transmittance = vec3<f32>(1.0);
    for (var plane = 0; plane < PLANES; plane++) {
        let distance = f32(plane) * PLANES_KM;
        let rise = distance * (2.0 * start * direction.z + distance);
        let radius = sqrt(start * start + rise);
        let altitude = eye + rise / (start + radius);
        if (altitude > TOP) {
            break;
        }
        let row = sqrt(max(altitude, 0.0) / TOP);
        let cos_view = (start * direction.z + distance) / radius;
        let cos_sun = (start * baseline[0].z + distance * cos_gamma) / radius;
        light += transmittance * table(0.0, cos_sun, row)
            * (air_phase * table(1.0, cos_view, row) + haze_phase * table(2.0, cos_view, row));
        transmittance *= table(3.0, cos_view, row);
    }
    return vec3<f32>(
        dot(baseline[3].xyz, light),
        dot(baseline[4].xyz, light),
        dot(baseline[5].xyz, light),
    );
}
