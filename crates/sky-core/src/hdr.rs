//! From exposed light to an HDR display: HDR10 and scRGB.
//!
//! Twins: `shaders/hdr.wgsl`, `hdr10.wgsl`, `scrgb.wgsl`. Simplifications: highlights roll off by one
//! curve that keeps their color. Out of scope: metadata of the stream, displays that map tones again.

/// Share of the display's peak above which highlights roll off.
pub const SHOULDER: f32 = 0.75;

/// What scRGB shows a 1 with \[cd·m⁻²\]. Source: IEC 61966-2-2.
pub const SCRGB_UNIT_NITS: f32 = 80.0;

/// Linear Rec.709 (sRGB) to linear Rec.2020. Source: ITU-R BT.2087-0, 2.4.
pub const REC2020_FROM_LINEAR_SRGB: [[f32; 3]; 3] = [
    [0.627_403_9, 0.329_283_04, 0.043_313_066],
    [0.069_097_29, 0.919_540_4, 0.011_362_316],
    [0.016_391_44, 0.088_013_31, 0.895_595_25],
];

/// Light of a display \[cd·m⁻²\] rolled off below its peak, where the brightest component is above
/// [`SHOULDER`] of it; hue and saturation stay.
#[must_use]
pub fn rolled_off(nits: [f32; 3], peak: f32) -> [f32; 3] {
    let start = SHOULDER * peak;
    let brightest = nits[0].max(nits[1]).max(nits[2]);
    if brightest <= start {
        return nits;
    }
    let room = peak - start;
    let scale = (peak - room * room / (brightest - start + room)) / brightest;
    nits.map(|c| c * scale)
}

/// Rec.2020 from linear sRGB; colors outside it end on its edge.
#[must_use]
pub fn rec2020_from_linear_srgb(rgb: [f32; 3]) -> [f32; 3] {
    REC2020_FROM_LINEAR_SRGB.map(|row| {
        row.iter()
            .zip(rgb)
            .map(|(m, c)| m * c)
            .sum::<f32>()
            .max(0.0)
    })
}

/// The perceptual quantizer of a display's light \[cd·m⁻²\], 0–1. Source: SMPTE ST 2084, ITU-R
/// BT.2100-2 Table 4.
#[must_use]
pub fn pq_encoded(nits: f32) -> f32 {
    const M1: f32 = 2610.0 / 16384.0;
    const M2: f32 = 2523.0 / 4096.0 * 128.0;
    const C1: f32 = 3424.0 / 4096.0;
    const C2: f32 = 2413.0 / 4096.0 * 32.0;
    const C3: f32 = 2392.0 / 4096.0 * 32.0;
    let y = (nits / 10_000.0).clamp(0.0, 1.0).powf(M1);
    ((C1 + C2 * y) / (1.0 + C3 * y)).powf(M2)
}

/// The pixel of an HDR10 target: exposed linear sRGB, 1 shown with `white_nits`.
#[must_use]
pub fn hdr10(exposed: [f32; 3], white_nits: f32, peak_nits: f32) -> [f32; 3] {
    let nits = rec2020_from_linear_srgb(exposed).map(|c| c * white_nits);
    rolled_off(nits, peak_nits).map(pq_encoded)
}

/// The pixel of an scRGB target: exposed linear sRGB, 1 shown with `white_nits`. Components below 0
/// are colors outside sRGB.
#[must_use]
pub fn scrgb(exposed: [f32; 3], white_nits: f32, peak_nits: f32) -> [f32; 3] {
    rolled_off(exposed.map(|c| c * white_nits), peak_nits).map(|c| c / SCRGB_UNIT_NITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of BT.2100's PQ: 0.01, 1, 100, 1000 and 10 000 cd/m².
    #[test]
    fn the_quantizer_has_the_published_values() {
        for (nits, expected) in [
            (0.0, 0.0),
            (0.1, 0.0623),
            (1.0, 0.1499),
            (100.0, 0.5081),
            (203.0, 0.5807),
            (1000.0, 0.7518),
            (10_000.0, 1.0),
        ] {
            let found = pq_encoded(nits);
            assert!((found - expected).abs() < 1e-4, "{nits}: {found}");
        }
    }

    #[test]
    fn white_stays_white_and_luminance_stays() {
        for row in REC2020_FROM_LINEAR_SRGB {
            let sum: f32 = row.iter().sum();
            assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        }
        // luminances of Rec.2020's primaries, BT.2020 Table 4
        let of_2020 = [0.2627_f32, 0.6780, 0.0593];
        for (c, expected) in [0.2126_f32, 0.7152, 0.0722].into_iter().enumerate() {
            let found: f32 = (0..3)
                .map(|row| of_2020[row] * REC2020_FROM_LINEAR_SRGB[row][c])
                .sum();
            assert!((found - expected).abs() < 1e-4, "{c}: {found}");
        }
    }

    #[test]
    fn highlights_keep_their_color_and_stay_below_the_peak() {
        let mut last = 0.0;
        for i in 0..=200_u8 {
            let bright = 1e-2 * 10.0_f32.powf(f32::from(i) / 20.0);
            let [r, g, b] = rolled_off([bright, 0.5 * bright, 0.1 * bright], 1000.0);
            assert!(r >= last && r <= 1000.0, "{bright}: {r}");
            assert!((g / r - 0.5).abs() < 1e-5 && (b / r - 0.1).abs() < 1e-5);
            if bright <= 750.0 {
                assert!((r - bright).abs() < 1e-6 * bright);
            }
            last = r;
        }
        assert!(last > 999.0);
    }

    #[test]
    fn white_is_shown_with_the_nits_asked_for() {
        let [r, g, b] = hdr10([1.0; 3], 203.0, 1000.0);
        let expected = pq_encoded(203.0);
        assert!([r, g, b].iter().all(|c| (c - expected).abs() < 1e-5));
        let light = scrgb([1.0; 3], 203.0, 1000.0);
        assert!(light.iter().all(|c| (c * 80.0 - 203.0).abs() < 1e-3));
    }
}
