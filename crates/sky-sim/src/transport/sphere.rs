//! Straight lines and spheres about the Earth's center.

/// How close a line comes to the center \[km\], from a point on it and the zenith cosine there.
#[inline(always)]
pub(super) fn impact_parameter(radius: f64, cosine: f64) -> f64 {
    (radius * radius * ((1.0 - cosine) * (1.0 + cosine)).max(0.0)).sqrt()
}

/// Half the chord that a sphere cuts from a line of given impact parameter; 0 if it misses \[km\].
#[inline(always)]
pub(super) fn half_chord(radius: f64, impact: f64) -> f64 {
    // keeps meters at thousands of kilometers
    ((radius - impact) * (radius + impact)).max(0.0).sqrt()
}

/// Cosine of the zenith angle of the horizon of a sphere, seen from a height above it \[km\].
pub(super) fn horizon_cosine(height: f64, sphere_radius: f64) -> f64 {
    let height = height.max(0.0);
    let radius = sphere_radius + height;
    -(height * (radius + sphere_radius)).sqrt() / radius
}
