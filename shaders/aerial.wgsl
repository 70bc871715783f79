// Transmittance and in-scattered light of a finite path. Twin: crates/sky-core/src/aerial.rs.

// A point of a ray: altitude [km] and cosine of the ray's zenith angle.
fn along(start: vec2<f32>, distance_km: f32) -> vec2<f32> {
    let radius = EARTH_RADIUS_KM + start.x;
    let rise = distance_km * (distance_km + 2.0 * radius * start.y);
    let there = sqrt(max(radius * radius + rise, 1.0));
    return vec2<f32>(
        start.x + rise / (there + radius),
        clamp((distance_km + radius * start.y) / there, -1.0, 1.0),
    );
}

fn air_level(altitude_km: f32) -> vec4<f32> {
    let place = max(altitude_km / LEVEL_STEP_KM, 0.0);
    let lower = min(u32(place), LEVELS - 2u);
    let fraction = place - f32(lower);
    let share = min(fraction, 1.0);
    return mix(
        aerial.levels[lower],
        aerial.levels[lower + 1u],
        vec4<f32>(fraction, share, share, 0.0),
    );
}

// Mean along a section of a density by its logarithm at start, middle and end.
fn mean_of_exponential(start: f32, middle: f32, end: f32) -> f32 {
    let x = abs(start - end);
    let mean = select((1.0 - exp(-x)) / max(x, 0.01), 1.0 - x * (0.5 - x / 6.0), x < 0.01);
    let bend = middle - 0.5 * (start + end);
    return mean * exp(max(start, end) + bend * 4.0 / sqrt(36.0 + x * x));
}

fn section_depth(start: vec2<f32>, end: vec2<f32>, length_km: f32) -> vec4<f32> {
    let middle = along(start, 0.5 * length_km);
    let a = air_level(start.x);
    let m = air_level(middle.x);
    let b = air_level(end.x);
    let haze = -vec3<f32>(start.x, middle.x, end.x) * aerial.haze_per_scale_height;
    let thin = (a + 4.0 * m + b) / 6.0;
    return length_km * (aerial.air_per_km * mean_of_exponential(a.x, m.x, b.x)
        + aerial.gas_per_km * thin.y
        + aerial.haze_per_km * mean_of_exponential(haze.x, haze.y, haze.z)
        + aerial.stratosphere_per_km * thin.z);
}

// Transmittance of red, green, blue and luminance.
fn transmittance_of(depth: vec4<f32>) -> vec4<f32> {
    let through = exp(-depth);
    return clamp(vec4<f32>(
        dot(aerial.red_weights, through),
        dot(aerial.green_weights, through),
        dot(aerial.blue_weights, through),
        dot(aerial.luminance_weights, through),
    ), vec4<f32>(0.0, 0.0, 0.0, 0.0), vec4<f32>(1.0, 1.0, 1.0, 1.0));
}

fn node_altitude(node: u32) -> f32 {
    return aerial.node_altitudes_km[node / 4u][node % 4u];
}

fn node_sum(node: u32, basis: Basis) -> vec3<f32> {
    let k = node * TERMS;
    let sum = aerial.coefficients[k] * basis.a.x + aerial.coefficients[k + 1u] * basis.a.y
        + aerial.coefficients[k + 2u] * basis.a.z + aerial.coefficients[k + 3u] * basis.a.w
        + aerial.coefficients[k + 4u] * basis.b.x + aerial.coefficients[k + 5u] * basis.b.y
        + aerial.coefficients[k + 6u] * basis.b.z + aerial.coefficients[k + 7u] * basis.b.w
        + aerial.coefficients[k + 8u] * basis.c.x + aerial.coefficients[k + 9u] * basis.c.y
        + aerial.coefficients[k + 10u] * basis.c.z + aerial.coefficients[k + 11u] * basis.c.w
        + aerial.coefficients[k + 12u] * basis.d.x + aerial.coefficients[k + 13u] * basis.d.y
        + aerial.coefficients[k + 14u] * basis.d.z + aerial.coefficients[k + 15u] * basis.d.w
        + aerial.coefficients[k + 16u] * basis.e.x + aerial.coefficients[k + 17u] * basis.e.y
        + aerial.coefficients[k + 18u] * basis.e.z + aerial.coefficients[k + 19u] * basis.e.w
        + aerial.coefficients[k + 20u] * basis.f.x + aerial.coefficients[k + 21u] * basis.f.y;
    return sum.xyz;
}

// The sky at a place of a ray in linear sRGB [cd/m2].
fn sky_at(place: vec2<f32>, gamma: f32, cos_gamma: f32) -> vec3<f32> {
    let nodes = u32(aerial.node_count);
    let altitude_km = clamp(place.x, node_altitude(0u), node_altitude(nodes - 1u));
    var upper = 1u;
    while (upper + 1u < nodes && node_altitude(upper) < altitude_km) {
        upper = upper + 1u;
    }
    let low = node_altitude(upper - 1u);
    let fraction = (altitude_km - low) / (node_altitude(upper) - low);
    let x = (EARTH_RADIUS_KM + altitude_km) / vec2<f32>(AIR_SCALE_HEIGHT_KM, HAZE_SCALE_HEIGHT_KM);
    let basis = sky_basis(place.y, vec4<f32>(x, sqrt(0.5 * x)), gamma, cos_gamma);
    let sum = mix(node_sum(upper - 1u, basis), node_sum(upper, basis), fraction);
    let left = exp(air_level(place.x).x - air_level(altitude_km).x);
    return left * linear_srgb_from_yxy(vec3<f32>(exp(sum.x), within_locus(sum.yz)));
}

fn molecular_scattering(cos_gamma: f32) -> f32 {
    return 0.75 * (1.0 + cos_gamma * cos_gamma) + SCATTERED_BEFORE;
}

// The sky from a place toward the ray, or mirrored at the horizontal where the ray descends.
fn sky_toward(place: vec2<f32>, gamma: f32, cos_gamma: f32, descends: bool) -> vec3<f32> {
    let cosine = select(place.y, -place.y, descends);
    let across = sqrt(max(1.0 - cosine * cosine, 0.0)) * aerial.sun_sin_cos.x;
    let level = cosine * aerial.sun_sin_cos.y;
    let nearest = clamp(cos_gamma, level - across, level + across);
    let air = aerial.air_per_km.z * exp(air_level(place.x).x);
    let haze = aerial.haze_per_km.z * exp(-place.x * aerial.haze_per_scale_height);
    let mirrored = clamp(cos_gamma + (nearest - cos_gamma) * air / (air + haze), -1.0, 1.0);
    let mirrored_gamma = angle_from(sqrt(1.0 - mirrored * mirrored), mirrored);
    let ratio = molecular_scattering(cos_gamma) / molecular_scattering(mirrored);
    return select(1.0, ratio, descends) * sky_at(
        vec2<f32>(place.x, cosine),
        select(gamma, mirrored_gamma, descends),
        select(cos_gamma, mirrored, descends),
    );
}

fn section_end(section: f32) -> f32 {
    let share = section / SECTIONS;
    return share * share;
}

struct AerialPath {
    // red, green, blue, luminance
    transmittance: vec4<f32>,
    // linear sRGB [cd/m2]
    inscatter: vec3<f32>,
}

// Optical depths of a ray that rises from its lowest point.
fn rising_depth(bottom: vec2<f32>, length_km: f32) -> vec4<f32> {
    var depth = vec4<f32>(0.0, 0.0, 0.0, 0.0);
    var lower = bottom;
    for (var i = 0.0; i < aerial.rise_ends; i = i + 1.0) {
        let upper = along(bottom, length_km * section_end(i + 1.0));
        let length = length_km * (section_end(i + 1.0) - section_end(i));
        depth = depth + section_depth(lower, upper, length);
        lower = upper;
    }
    return depth;
}

// color = transmittance * object + inscatter, for an object at a distance [km] in a local direction.
//
// The loop runs over the ends of the sections: those of the descent, then start and end of the rise.
// Its bound is a uniform (path_ends), for drivers that would unroll it into very long programs.
fn aerial_path(altitude_km: f32, direction: vec3<f32>, distance_km: f32) -> AerialPath {
    let start = vec2<f32>(altitude_km, direction.z);
    let angles = angle_from_sun(direction, aerial.sun_sin_cos);
    let lowest = clamp(-(EARTH_RADIUS_KM + altitude_km) * start.y, 0.0, distance_km);
    let rise = min(distance_km - lowest, distance_to_top(along(start, lowest)));
    var depth = vec4<f32>(0.0, 0.0, 0.0, 0.0);
    var light = vec3<f32>(0.0, 0.0, 0.0);
    var last = start;
    var last_sky = vec3<f32>(0.0, 0.0, 0.0);
    let first = select(SECTIONS + 1.0, 0.0, lowest > 0.0);
    let stop = select(SECTIONS + 1.0, aerial.path_ends, rise > 0.0);
    for (var k = first; k < stop; k = k + 1.0) {
        let descends = k < SECTIONS + 0.5;
        let is_end = k > SECTIONS + 1.5;
        var far = select(lowest, lowest + rise, is_end);
        if (descends) {
            far = lowest * (1.0 - section_end(SECTIONS - k));
        }
        let here = along(start, far);
        let here_sky = sky_toward(here, angles.x, angles.y, descends);
        if (descends && k > 0.5) {
            let length = lowest * (section_end(SECTIONS + 1.0 - k) - section_end(SECTIONS - k));
            let section = section_depth(last, here, length);
            light = light + transmittance_of(depth).xyz
                * max(here_sky - transmittance_of(section).xyz * last_sky, vec3<f32>(0.0, 0.0, 0.0));
            depth = depth + section;
        }
        if (is_end) {
            let section = rising_depth(last, rise);
            light = light + transmittance_of(depth).xyz
                * max(last_sky - transmittance_of(section).xyz * here_sky, vec3<f32>(0.0, 0.0, 0.0));
            depth = depth + section;
        }
        last = here;
        last_sky = here_sky;
    }
    return AerialPath(transmittance_of(depth), light);
}

// Distance at which a rising ray leaves the air; not positive above it.
fn distance_to_top(bottom: vec2<f32>) -> f32 {
    let radius = EARTH_RADIUS_KM + bottom.x;
    let up = TOP_OF_AIR_KM - bottom.x;
    let half = radius * max(bottom.y, 0.0);
    let product = up * (up + 2.0 * radius);
    return product / max(half + sqrt(max(half * half + product, 0.0)), 1e-6);
}

fn distance_to_ground(altitude_km: f32, cosine: f32) -> f32 {
    let down = -(EARTH_RADIUS_KM + altitude_km) * cosine;
    let tangent = altitude_km * (altitude_km + 2.0 * EARTH_RADIUS_KM);
    return tangent / max(down + sqrt(max(down * down - tangent, 0.0)), 1e-6);
}
