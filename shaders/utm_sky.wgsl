// The sky formula: air masses, products, light. Twins: crates/sky-core/src/air_mass.rs, extended.rs
// and utm_sky.rs.

// The angle, 0 to pi, from its sine (not negative) and cosine times any common factor.
fn angle_from(sine: f32, cosine: f32) -> f32 {
    let side = abs(cosine);
    let ratio = min(sine, side) / max(max(sine, side), 1.1754944e-38);
    let square = ratio * ratio;
    let fourth = square * square;
    let low = (0.99999935 - 0.33326515 * square) + (0.19881482 - 0.1348719 * square) * fourth;
    let high = (0.083871156 - 0.03701297 * square) + 0.007863366 * fourth;
    let arc = ratio * (low + high * (fourth * fourth));
    let acute = select(arc, 1.57079633 - arc, sine > side);
    return select(acute, 3.14159265 - acute, cosine < 0.0);
}

// Chapman's function above the horizontal as numerator and denominator, for air and haze at once.
// x is the radius in scale heights, root the square root of x/2.
fn chapman_above(cosine: f32, x: vec2<f32>, root: vec2<f32>) -> vec4<f32> {
    let u = root * cosine;
    let curve = 1.0 + u * (0.6490919 + u * 0.4824886);
    let numerator = ((0.1239278 * u + 0.5564682) * u + 1.116127) * u + 1.0;
    let denominator = (((0.2196563 * u + 0.986262) * u + 2.089938) * u + 2.244429) * u + 1.0;
    return vec4<f32>(
        1.7724539 * root * numerator * (x * curve + (curve - 0.625)),
        denominator * (x * curve),
    );
}

// One over the relative air masses of air and haze.
fn reciprocal_masses(cosine: f32, radii: vec4<f32>) -> vec2<f32> {
    let x = radii.xy;
    let root = radii.zw;
    let above = chapman_above(abs(cosine), x, root);
    if (cosine >= 0.0) {
        return above.zw / above.xy;
    }
    let sine = sqrt(max(1.0 - cosine * cosine, 1e-6));
    let exponent = x * (cosine * cosine / (1.0 + sine));
    let tangent = chapman_above(0.0, x * sine, root * sqrt(sine));
    let growth = exp(min(exponent, vec2<f32>(60.0, 60.0)));
    return 1.0 / (2.0 * growth * (tangent.xy / tangent.zw) - above.xy / above.zw);
}

// The 22 products, four a vector, the last two 0.
struct Basis {
    a: vec4<f32>,
    b: vec4<f32>,
    c: vec4<f32>,
    d: vec4<f32>,
    e: vec4<f32>,
    f: vec4<f32>,
}

fn sky_basis(cosine: f32, radii: vec4<f32>, gamma: f32, cos_gamma: f32) -> Basis {
    let masses = reciprocal_masses(cosine, radii);
    let near = 1.0 / (1.0 + vec4<f32>(1.0, 3.0, 10.0, 50.0) * masses.x);
    let far = 1.0 / (1.0 + vec4<f32>(200.0, 1000.0, 0.0, 0.0) * masses.x);
    let haze = 1.0 / (1.0 + vec4<f32>(5.0, 20.0, 100.0, 0.0) * masses.y);
    let e1 = exp(-gamma);
    let e2 = e1 * e1;
    let e4 = e2 * e2;
    var basis: Basis;
    basis.a = vec4<f32>(1.0, near.y, e2, near.w);
    basis.b = vec4<f32>(far.x, cos_gamma * cos_gamma, far.x * cos_gamma, haze.x * cos_gamma);
    basis.c = vec4<f32>(haze.x, haze.x * e2, near.w * cos_gamma, near.y * cos_gamma);
    basis.d = vec4<f32>(far.y, haze.z * e1, far.y * cos_gamma, near.x * (cos_gamma * cos_gamma));
    basis.e = vec4<f32>(far.y * e1, near.x * (e4 * e4), near.x, far.x * e1);
    basis.f = vec4<f32>(near.z * cos_gamma, haze.y * e1, 0.0, 0.0);
    return basis;
}

// A chromaticity that light can have: what leads out of the spectral locus ends on its edge.
fn within_locus(xy: vec2<f32>) -> vec2<f32> {
    let from_white = xy - 0.33333333;
    let a = vec4<f32>(-1.86677, -2.80894, -3.31911, -3.44584) * from_white.x
        + vec4<f32>(-2.13774, -1.5333, -1.02294, -0.4178) * from_white.y;
    let b = vec4<f32>(-1.53861, 2.76373, 3.00551, 1.82687) * from_white.x
        + vec4<f32>(1.53681, 3.16304, 3.01775, -3.93653) * from_white.y;
    let most = max(a, b);
    let far = max(1.0, max(max(most.x, most.y), max(most.z, most.w)));
    return 0.33333333 + from_white / far;
}

// The angle from the sun and its cosine; directions are in the local frame (z up, the sun above x),
// the sun as sine and cosine of its zenith angle. The third is the angle's sine.
fn angle_from_sun(direction: vec3<f32>, sun: vec2<f32>) -> vec3<f32> {
    let cos_gamma = direction.x * sun.x + direction.z * sun.y;
    let across = direction.z * sun.x - direction.x * sun.y;
    let sine = sqrt(direction.y * direction.y + across * across);
    return vec3<f32>(angle_from(sine, cos_gamma), cos_gamma, sine);
}
