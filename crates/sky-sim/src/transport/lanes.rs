//! Eight wavelengths at a time: the arithmetic that the hot loops are made of.
//!
//! Every operation works on each lane alone, so results do not depend on the vector width that the
//! machine offers: the bits are the same with SSE2, AVX2 or AVX-512. Light is summed in single
//! precision, which is some 10⁻⁶ of a radiance; geometry stays in double precision.

/// Wavelengths in one vector.
pub(super) const WIDTH: usize = 8;

/// A value for each of eight wavelengths.
pub(super) type Lanes = [f32; WIDTH];

/// Zero in every lane.
pub(super) const ZERO: Lanes = [0.0; WIDTH];

/// A coefficient for the arithmetic of lanes.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    reason = "lanes hold light in single precision"
)]
pub(super) const fn lane(x: f64) -> f32 {
    x as f32
}

/// Number of vectors that hold `n` wavelengths.
pub(super) const fn vectors(n: usize) -> usize {
    n.div_ceil(WIDTH)
}

/// Spreads a level-major table `[row * n + wavelength]` over padded vectors; the padding repeats the
/// last wavelength, so that padded lanes stay ordinary numbers.
pub(super) fn pack(table: &[f64], n: usize) -> Vec<Lanes> {
    table
        .chunks_exact(n)
        .flat_map(|row| {
            (0..vectors(n))
                .map(move |v| core::array::from_fn(|l| lane(row[(v * WIDTH + l).min(n - 1)])))
        })
        .collect()
}

/// `acc += w * x`
#[inline(always)]
pub(super) fn add_scaled(acc: &mut Lanes, w: f32, x: &Lanes) {
    // copies, so that the compiler need not wonder whether the two overlap
    let (mut sum, x) = (*acc, *x);
    for l in 0..WIDTH {
        sum[l] += w * x[l];
    }
    *acc = sum;
}

/// `acc += w * x`, lane by lane
#[inline(always)]
pub(super) fn add_product(acc: &mut Lanes, w: &Lanes, x: &Lanes) {
    let (mut sum, w, x) = (*acc, *w, *x);
    for l in 0..WIDTH {
        sum[l] += w[l] * x[l];
    }
    *acc = sum;
}

/// `acc += w * x` in the lanes where x is positive
#[inline(always)]
pub(super) fn add_positive(acc: &mut Lanes, w: &Lanes, x: &Lanes) {
    let (mut sum, w, x) = (*acc, *w, *x);
    for l in 0..WIDTH {
        sum[l] += w[l] * x[l].max(0.0);
    }
    *acc = sum;
}

/// `(1 - f) * a + f * b`
#[inline(always)]
pub(super) fn lerp(a: &Lanes, b: &Lanes, f: f32) -> Lanes {
    let mut out = ZERO;
    for l in 0..WIDTH {
        out[l] = a[l] + f * (b[l] - a[l]);
    }
    out
}

/// e to the power of each lane; relative error below 2e-7 near 0, arguments clamped to ±60.
///
/// The clamp keeps products of a few exponentials out of the range where single precision fades out.
#[inline(always)]
pub(super) fn exp(x: &Lanes) -> Lanes {
    const SHIFT: f32 = 12_582_912.0; // 1.5 * 2^23: adding it rounds to an integer
    const LN2_HIGH: f32 = 355.0 / 512.0; // ln 2 to nine bits
    const LN2_LOW: f32 = -2.121_944_4e-4;
    let mut out = ZERO;
    for l in 0..WIDTH {
        let x = x[l].clamp(-60.0, 60.0);
        let shifted = x * core::f32::consts::LOG2_E + SHIFT;
        let k = shifted - SHIFT;
        let r = (x - k * LN2_HIGH) - k * LN2_LOW;
        // Taylor to r^7, |r| <= ln 2 / 2, in pairs so that products need not wait for one another
        let r2 = r * r;
        let low = (1.0 + r) + (1.0 / 2.0 + 1.0 / 6.0 * r) * r2;
        let high = (1.0 / 24.0 + 1.0 / 120.0 * r) + (1.0 / 720.0 + 1.0 / 5_040.0 * r) * r2;
        let p = low + high * (r2 * r2);
        // the low bits of `shifted` hold k; move them into the exponent
        out[l] = p * f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
    }
    out
}

/// Arc cosine of each lane \[rad\], arguments in −1..1; error below 1e-15.
#[inline(always)]
pub(super) fn acos(x: &[f64; WIDTH]) -> [f64; WIDTH] {
    // arcsine up to 1/2 by the rational function of fdlibm, beyond through half the angle
    const P: [f64; 6] = [
        1.666_666_666_666_666_6e-1,
        -3.255_658_186_224_009e-1,
        2.012_125_321_348_629_3e-1,
        -4.005_553_450_067_941e-2,
        7.915_349_942_898_145e-4,
        3.479_331_075_960_212e-5,
    ];
    const Q: [f64; 4] = [
        -2.403_394_911_734_414,
        2.020_945_760_233_505_7,
        -6.882_839_716_054_533e-1,
        7.703_815_055_590_194e-2,
    ];
    let mut out = [0.0; WIDTH];
    for l in 0..WIDTH {
        let size = x[l].abs();
        let (whole, half) = (size * size, 0.5 * (1.0 - size));
        let z = if size > 0.5 { half } else { whole };
        let s = z.sqrt();
        let p = z * (P[0] + z * (P[1] + z * (P[2] + z * (P[3] + z * (P[4] + z * P[5])))));
        let q = 1.0 + z * (Q[0] + z * (Q[1] + z * (Q[2] + z * Q[3])));
        let arcsine = s + s * (p / q);
        let angle = if size > 0.5 {
            2.0 * arcsine
        } else {
            core::f64::consts::FRAC_PI_2 - arcsine
        };
        out[l] = if x[l] < 0.0 {
            core::f64::consts::PI - angle
        } else {
            angle
        };
    }
    out
}

/// Transmittance from the start of a segment to its middle and to its end, from the extinction per
/// length at start, middle and end (a parabola through the three).
#[inline(always)]
pub(super) fn simpson_transmittance(
    length: f32,
    a: &Lanes,
    m: &Lanes,
    b: &Lanes,
) -> (Lanes, Lanes) {
    let (mut middle, mut end) = (ZERO, ZERO);
    for l in 0..WIDTH {
        middle[l] = -length * (5.0 * a[l] + 8.0 * m[l] - b[l]) / 24.0;
        end[l] = -length * (a[l] + 4.0 * m[l] + b[l]) / 6.0;
    }
    (exp(&middle), exp(&end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_agrees_with_the_library() {
        for i in -600_i16..=600 {
            let x = f32::from(i) * 0.1;
            let expected = f64::from(x).exp();
            let error = (f64::from(exp(&[x; WIDTH])[3]) / expected - 1.0).abs();
            assert!(
                error < 2e-7 + 1e-7 * f64::from(x).abs(),
                "exp({x}): {error}"
            );
        }
        assert!((exp(&ZERO)[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn acos_agrees_with_the_library() {
        for i in -1000..=1000 {
            let x = f64::from(i) * 1e-3;
            let got = acos(&[x; WIDTH])[5];
            assert!((got - x.acos()).abs() < 1e-15, "acos({x}) = {got}");
        }
    }

    #[test]
    fn packing_pads_with_the_last_wavelength() {
        let p = pack(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 3);
        assert_eq!(p.len(), 2);
        assert_eq!(
            p[1].map(f32::to_bits),
            [4.0, 5.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0_f32].map(f32::to_bits)
        );
    }
}
