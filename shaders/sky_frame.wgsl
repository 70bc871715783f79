// The light from a direction in one frame's sky, and the sun's disc. Twins: SkyFrame in
// crates/sky-core/src/utm_sky.rs and SunDisc in light.rs.

// A cosine as the formula takes it: below that of the lowest fitted ring it bends to stay.
fn held(cosine: f32, lowest: f32) -> f32 {
    let below = clamp((lowest - cosine) / LOWEST_RING_BEND, 0.0, 1.0);
    return max(cosine, lowest) - LOWEST_RING_BEND * (below - 0.5 * below * below);
}

// Luminance [cd/m2], x and y from a direction in the local frame at or above the horizon.
fn sky_yxy(cosine: f32, gamma: f32, cos_gamma: f32) -> vec3<f32> {
    let basis = sky_basis(held(cosine, sky.cos_lowest), vec4<f32>(sky.radii, sky.radii_roots), gamma, cos_gamma);
    let a = sky.coefficients[0] * basis.a.x + sky.coefficients[1] * basis.a.y
        + sky.coefficients[2] * basis.a.z + sky.coefficients[3] * basis.a.w;
    let b = sky.coefficients[4] * basis.b.x + sky.coefficients[5] * basis.b.y
        + sky.coefficients[6] * basis.b.z + sky.coefficients[7] * basis.b.w;
    let c = sky.coefficients[8] * basis.c.x + sky.coefficients[9] * basis.c.y
        + sky.coefficients[10] * basis.c.z + sky.coefficients[11] * basis.c.w;
    let d = sky.coefficients[12] * basis.d.x + sky.coefficients[13] * basis.d.y
        + sky.coefficients[14] * basis.d.z + sky.coefficients[15] * basis.d.w;
    let e = sky.coefficients[16] * basis.e.x + sky.coefficients[17] * basis.e.y
        + sky.coefficients[18] * basis.e.z + sky.coefficients[19] * basis.e.w;
    let f = sky.coefficients[20] * basis.f.x + sky.coefficients[21] * basis.f.y;
    let sum = ((a + b) + (c + d)) + (e + f);
    return vec3<f32>(exp(sum.x), within_locus(sum.yz));
}

// A world direction, of any length, as a unit vector in the local frame.
fn to_local(world: vec3<f32>) -> vec3<f32> {
    return normalize(vec3<f32>(
        dot(sky.local_x, world),
        dot(sky.local_y, world),
        dot(sky.local_z, world),
    ));
}

// Light of the sun's disc, black outside it and below the horizon.
fn sun_disc(direction: vec3<f32>) -> vec3<f32> {
    let sun = sky.sun_sin_cos;
    let cos_gamma = direction.x * sun.x + direction.z * sun.y;
    let across = direction.z * sun.x - direction.x * sun.y;
    let from_center = (direction.y * direction.y + across * across) / (sky.sin_sun_radius * sky.sin_sun_radius);
    let limb = 1.0 - LIMB_DARKENING * (1.0 - sqrt(max(1.0 - from_center, 0.0)));
    let lower = sky.sun_lower_cosine;
    let height = (direction.z - lower) / max(sky.sun_upper_cosine - lower, 1e-9);
    let light = limb * mix(sky.sun_lower, sky.sun_upper, clamp(height, 0.0, 1.0));
    let inside = cos_gamma > 0.0 && from_center < 1.0 && is_sky(direction);
    return select(vec3<f32>(0.0, 0.0, 0.0), light, inside);
}
