// What one frame's sky needs, and the light from a direction. Twin: SkyFrame in
// crates/sky-core/src/utm_sky.rs and Picture in picture.rs.

struct SkyUniform {
    // of ln Y, x and y for each product
    coefficients: array<vec4<f32>, 22>,
    // radii of air and haze in scale heights, roots of their halves
    radii: vec4<f32>,
    // sine and cosine of the sun's zenith angle, cosine of the horizon's, altitude [km]
    place: vec4<f32>,
    // rows that turn a world direction into the local frame
    local_x: vec4<f32>,
    local_y: vec4<f32>,
    local_z: vec4<f32>,
    // light of the disc's center at its upper and lower limb; w: the cosines they belong to
    sun_upper: vec4<f32>,
    sun_lower: vec4<f32>,
    // light of the ground; w: sine of the sun's radius
    ground: vec4<f32>,
    // exposure, tone curve, dither (1 over levels), 1 where the target encodes by itself
    display: vec4<f32>,
    // 1: paint what lies outside the domain; scale of the baked sky and its inverse; cosine of the
    // lowest direction that the table was fitted to
    debug: vec4<f32>,
}

@group(0) @binding(0) var<uniform> sky: SkyUniform;

// A cosine as the formula takes it: below that of the lowest fitted ring it bends to stay.
fn held(cosine: f32, lowest: f32) -> f32 {
    let below = clamp((lowest - cosine) / 1.4e-3, 0.0, 1.0);
    return max(cosine, lowest) - 1.4e-3 * (below - 0.5 * below * below);
}

// Luminance [cd/m2], x and y from a direction in the local frame at or above the horizon.
fn sky_yxy(cosine: f32, gamma: f32, mu: f32) -> vec3<f32> {
    let basis = sky_basis(held(cosine, sky.debug.w), sky.radii, gamma, mu);
    let a = coefficient(0u) * basis.a.x + coefficient(1u) * basis.a.y
        + coefficient(2u) * basis.a.z + coefficient(3u) * basis.a.w;
    let b = coefficient(4u) * basis.b.x + coefficient(5u) * basis.b.y
        + coefficient(6u) * basis.b.z + coefficient(7u) * basis.b.w;
    let c = coefficient(8u) * basis.c.x + coefficient(9u) * basis.c.y
        + coefficient(10u) * basis.c.z + coefficient(11u) * basis.c.w;
    let d = coefficient(12u) * basis.d.x + coefficient(13u) * basis.d.y
        + coefficient(14u) * basis.d.z + coefficient(15u) * basis.d.w;
    let e = coefficient(16u) * basis.e.x + coefficient(17u) * basis.e.y
        + coefficient(18u) * basis.e.z + coefficient(19u) * basis.e.w;
    let f = coefficient(20u) * basis.f.x + coefficient(21u) * basis.f.y;
    let sum = ((a + b) + (c + d)) + (e + f);
    return vec3<f32>(exp(sum.x), within_locus(sum.yz));
}

// A world direction, of any length, as a unit vector in the local frame.
fn to_local(world: vec3<f32>) -> vec3<f32> {
    return normalize(vec3<f32>(
        dot(sky.local_x.xyz, world),
        dot(sky.local_y.xyz, world),
        dot(sky.local_z.xyz, world),
    ));
}

// Light of the sun's disc, black outside it and below the horizon.
fn sun_disc(direction: vec3<f32>) -> vec3<f32> {
    let sun = place_of_sun();
    let upper = upper_limb();
    let lower = lower_limb();
    let mu = direction.x * sun.x + direction.z * sun.y;
    let across = direction.z * sun.x - direction.x * sun.y;
    let from_center = (direction.y * direction.y + across * across) / (sun.w * sun.w);
    let limb = 1.0 - 0.6 * (1.0 - sqrt(max(1.0 - from_center, 0.0)));
    let height = (direction.z - lower.w) / max(upper.w - lower.w, 1e-9);
    let light = limb * mix(lower.xyz, upper.xyz, clamp(height, 0.0, 1.0));
    let inside = mu > 0.0 && from_center < 1.0 && direction.z >= sun.z - 2e-7;
    return select(vec3<f32>(0.0, 0.0, 0.0), light, inside);
}
