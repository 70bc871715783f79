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

// Luminance [cd/m2], x and y from a direction in the local frame at or above the horizon.
fn sky_yxy(cosine: f32, gamma: f32, mu: f32) -> vec3<f32> {
    // below the lowest fitted ring the sky is that ring's
    let basis = sky_basis(max(cosine, sky.debug.w), sky.radii, gamma, mu);
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
    return vec3<f32>(exp(sum.x), sum.y, sum.z);
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
    let mu = direction.x * sky.place.x + direction.z * sky.place.y;
    let across = direction.z * sky.place.x - direction.x * sky.place.y;
    let from_center = sqrt(direction.y * direction.y + across * across) / sky.ground.w;
    let limb = 1.0 - 0.6 * (1.0 - sqrt(max(1.0 - from_center * from_center, 0.0)));
    let height = (direction.z - sky.sun_lower.w) / max(sky.sun_upper.w - sky.sun_lower.w, 1e-9);
    let light = limb * mix(sky.sun_lower.xyz, sky.sun_upper.xyz, clamp(height, 0.0, 1.0));
    let inside = mu > 0.0 && from_center < 1.0 && direction.z >= sky.place.z - 2e-7;
    return select(vec3<f32>(0.0, 0.0, 0.0), light, inside);
}
