// Nishita et al. 1993, both integrals marched; twin of crates/sky-baselines/src/nishita.rs.
// baseline[0]: the sun's direction, w: altitude, km; [1]: Rayleigh scattering per km at sea level,
// w: scale height of the air, km; [2]: the same of the haze; [3]-[5]: rows of XYZ from radiance,
// w: g.

const EARTH_RADIUS: f32 = 6371.0;
const TOP: f32 = 100.0;
const DOWN: i32 = 20;
const UP: i32 = 48;
const TO_SUN: i32 = 12;

fn lowest_km(altitude: f32, cos_view: f32) -> f32 {
    let sine = sqrt(max(1.0 - cos_view * cos_view, 0.0));
    return altitude - (EARTH_RADIUS + altitude) * cos_view * cos_view / (1.0 + sine);
}

fn to_top_km(altitude: f32, cos_zenith: f32) -> f32 {
    let along = (EARTH_RADIUS + altitude) * cos_zenith;
    let rise = (TOP - altitude) * (2.0 * EARTH_RADIUS + TOP + altitude);
    return sqrt(along * along + max(rise, 0.0)) - along;
}

// Altitude and radius at a distance along a ray.
fn point(altitude: f32, cos_zenith: f32, distance: f32) -> vec2<f32> {
    let start = EARTH_RADIUS + altitude;
    let rise = distance * (2.0 * start * cos_zenith + distance);
    let radius = sqrt(start * start + rise);
    return vec2<f32>(altitude + rise / (start + radius), radius);
}

fn densities(altitude: f32) -> vec2<f32> {
    return exp(-altitude / vec2<f32>(baseline[1].w, baseline[2].w));
}

fn optical_depth(lengths: vec2<f32>) -> vec3<f32> {
    return baseline[1].xyz * lengths.x + baseline[2].xyz * lengths.y;
}

fn columns_upward(altitude: f32, cos_zenith: f32) -> vec2<f32> {
    let length = to_top_km(altitude, cos_zenith);
    var sums = vec2<f32>(0.0);
    for (var i = 0; i < TO_SUN; i++) {
        let u = (f32(i) + 0.5) / f32(TO_SUN);
        sums += u * u * densities(point(altitude, cos_zenith, length * u * u * u).x);
    }
    return sums * (3.0 * length / f32(TO_SUN));
}

// Equivalent lengths of air and haze towards the sun; negative in the Earth's shadow.
fn columns(altitude: f32, cos_sun: f32) -> vec2<f32> {
    if (cos_sun >= 0.0) {
        return columns_upward(altitude, cos_sun);
    }
    let lowest = lowest_km(altitude, cos_sun);
    if (lowest < 0.0) {
        return vec2<f32>(-1.0);
    }
    return 2.0 * columns_upward(lowest, 0.0) - columns_upward(altitude, -cos_sun);
}

struct Path {
    light: vec3<f32>,
    transmittance: vec3<f32>,
}

fn segment(path: Path, from_km: f32, to_km: f32, cos_view: f32, cos_gamma: f32, phases: vec2<f32>) -> Path {
    let altitude = baseline[0].w;
    let step_km = to_km - from_km;
    let middle = from_km + 0.5 * step_km;
    let place = point(altitude, cos_view, middle);
    let density = densities(place.x);
    let depth = optical_depth(density * step_km);
    let through = exp(-depth);
    var light = path.light;
    let cos_sun = ((EARTH_RADIUS + altitude) * baseline[0].z + middle * cos_gamma) / place.y;
    let lengths = columns(place.x, cos_sun);
    if (lengths.x >= 0.0) {
        let scattered = optical_depth(density * phases);
        let series = 1.0 - depth * (0.5 - depth / 6.0);
        let share = select(series, (1.0 - through) / max(depth, vec3<f32>(1e-6)), depth > vec3<f32>(0.01));
        light += path.transmittance * scattered * share * step_km * exp(-optical_depth(lengths));
    }
    return Path(light, path.transmittance * through);
}

fn baseline_xyz(direction: vec3<f32>) -> vec3<f32> {
    let altitude = baseline[0].w;
    let cos_view = direction.z;
    if (cos_view < 0.0 && lowest_km(altitude, cos_view) < -1e-3) {
        return vec3<f32>(0.0);
    }
    let cos_gamma = clamp(dot(direction, baseline[0].xyz), -1.0, 1.0);
    let square = 1.0 + cos_gamma * cos_gamma;
    let g = baseline[3].w;
    let denominator = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_gamma);
    let phases = vec2<f32>(
        0.059683104 * square,
        0.11936621 * (1.0 - g * g) / (2.0 + g * g) * square / (denominator * sqrt(denominator)),
    );
    var path = Path(vec3<f32>(0.0), vec3<f32>(1.0));
    var from_km = 0.0;
    let lowest = max(-(EARTH_RADIUS + altitude) * cos_view, 0.0);
    if (lowest > 0.0) {
        for (var i = 1; i <= DOWN; i++) {
            let u = 1.0 - f32(i) / f32(DOWN);
            let to_km = lowest * (1.0 - u * u);
            path = segment(path, from_km, to_km, cos_view, cos_gamma, phases);
            from_km = to_km;
        }
    }
    let rest = to_top_km(altitude, cos_view) - lowest;
    for (var i = 1; i <= UP; i++) {
        let u = f32(i) / f32(UP);
        let to_km = lowest + rest * u * u * u;
        path = segment(path, from_km, to_km, cos_view, cos_gamma, phases);
        from_km = to_km;
    }
    return vec3<f32>(
        dot(baseline[3].xyz, path.light),
        dot(baseline[4].xyz, path.light),
        dot(baseline[5].xyz, path.light),
    );
}
