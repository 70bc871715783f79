//! Eight wavelengths at a time: the arithmetic that the hot loops are made of.
//!
//! Every operation works on each lane alone, so results do not depend on the vector width that the
//! machine offers: the bits are the same with SSE2, AVX2 or AVX-512.

/// Wavelengths in one vector.
pub(super) const WIDTH: usize = 8;

/// A value for each of eight wavelengths.
pub(super) type Lanes = [f64; WIDTH];

/// Zero in every lane.
pub(super) const ZERO: Lanes = [0.0; WIDTH];

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
            (0..vectors(n)).map(move |v| core::array::from_fn(|l| row[(v * WIDTH + l).min(n - 1)]))
        })
        .collect()
}

/// `acc += w * x`
#[inline(always)]
pub(super) fn add_scaled(acc: &mut Lanes, w: f64, x: &Lanes) {
    for l in 0..WIDTH {
        acc[l] += w * x[l];
    }
}

/// `(1 - f) * a + f * b`
#[inline(always)]
pub(super) fn lerp(a: &Lanes, b: &Lanes, f: f64) -> Lanes {
    let mut out = ZERO;
    for l in 0..WIDTH {
        out[l] = a[l] + f * (b[l] - a[l]);
    }
    out
}

/// 1/n! from n = 2.
const TAYLOR: [f64; 10] = [
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5_040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
    1.0 / 39_916_800.0,
];

/// e to the power of each lane; relative error below 1e-13, arguments clamped to ±700.
#[inline(always)]
pub(super) fn exp(x: &Lanes) -> Lanes {
    const SHIFT: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52: adding it rounds to an integer
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    let mut out = ZERO;
    for l in 0..WIDTH {
        let x = x[l].clamp(-700.0, 700.0);
        let shifted = x * core::f64::consts::LOG2_E + SHIFT;
        let k = shifted - SHIFT;
        let r = (x - k * LN2_HIGH) - k * LN2_LOW;
        // Taylor to r^11, |r| <= ln 2 / 2, in pairs so that products need not wait for one another
        let (r2, c) = (r * r, &TAYLOR);
        let r4 = r2 * r2;
        let low = (1.0 + r) + (c[0] + c[1] * r) * r2;
        let middle = (c[2] + c[3] * r) + (c[4] + c[5] * r) * r2;
        let high = (c[6] + c[7] * r) + (c[8] + c[9] * r) * r2;
        let p = low + (middle + high * r4) * r4;
        // the low bits of `shifted` hold k; move them into the exponent
        out[l] = p * f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    }
    out
}

/// Arc cosine of each lane \[rad\], arguments in −1..1; error below 1e-15.
#[inline(always)]
pub(super) fn acos(x: &Lanes) -> Lanes {
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
    let mut out = ZERO;
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
    length: f64,
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
        for i in 0..4000 {
            let x = f64::from(i) * 0.173 - 340.0;
            let got = exp(&[x; WIDTH])[3];
            assert!((got / x.exp() - 1.0).abs() < 1e-13, "exp({x}) = {got}");
        }
        assert!((exp(&ZERO)[0] - 1.0).abs() < 1e-15);
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
            p[1].map(f64::to_bits),
            [4.0, 5.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0_f64].map(f64::to_bits)
        );
    }
}
