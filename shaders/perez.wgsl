// Perez's formula. Twin: crates/sky-science/src/perez_sky.rs.

// F of the air mass and the angle from the sun; coefficients A to D in the vector, E apart.
fn perez(coefficients: vec4<f32>, e: f32, air_mass: f32, gamma: f32) -> f32 {
    let exponent = select(coefficients.y * air_mass, 0.0, coefficients.y == 0.0);
    let cos_gamma = cos(gamma);
    return (1.0 + coefficients.x * exp(exponent))
        * (1.0 + coefficients.z * exp(coefficients.w * gamma) + e * cos_gamma * cos_gamma);
}
