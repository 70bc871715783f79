//! From scene light to a picture: exposure, tone curve, gamut, encoding, dither.
//!
//! Twin: `shaders/tonemap.wgsl`. Out of scope: local adaptation, glare, displays beyond sRGB.

/// How bright light becomes a display's light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// Linear; what is brighter than white is white.
    #[default]
    None,
    /// x/(1 + x) on luminance. Source: Reinhard et al. 2002, Eq. 3.
    Reinhard,
    /// A rational curve like the ACES reference rendering. Source: Narkowicz 2015, five constants.
    Aces,
    /// Khronos PBR Neutral: true below 0.8, then rolling off with less saturation. Source: Khronos
    /// 2024 specification.
    Neutral,
}

impl Tone {
    /// Every curve with its name.
    pub const ALL: [(Self, &'static str); 4] = [
        (Self::None, "none"),
        (Self::Reinhard, "reinhard"),
        (Self::Aces, "aces"),
        (Self::Neutral, "neutral"),
    ];

    /// The number that the shader knows it by.
    #[must_use]
    pub const fn index(self) -> f32 {
        match self {
            Self::None => 0.0,
            Self::Reinhard => 1.0,
            Self::Aces => 2.0,
            Self::Neutral => 3.0,
        }
    }
}

/// Exposure \[m²·cd⁻¹\] from an exposure value at ISO 100: 1 stands for 1.2 · 2^EV cd·m⁻².
///
/// Source: ISO 2720 with a saturation-based speed (ISO 12232), lens factor 0.65.
#[must_use]
pub fn exposure_from_ev100(ev100: f32) -> f32 {
    1.0 / (1.2 * ev100.exp2())
}

/// The exposure value that a reflected-light meter with K = 12.5 shows for a mean luminance
/// \[cd·m⁻²\].
#[must_use]
pub fn ev100_from_luminance(luminance: f32) -> f32 {
    (luminance.max(1e-6) * 100.0 / 12.5).log2()
}

/// Luminance of linear sRGB.
#[must_use]
pub fn luminance([red, green, blue]: [f32; 3]) -> f32 {
    0.212_639 * red + 0.715_168_7 * green + 0.072_192_32 * blue
}

/// Exposed light under a tone curve, inside the display's cube.
#[must_use]
pub fn tone_mapped(exposed: [f32; 3], tone: Tone) -> [f32; 3] {
    let rgb = match tone {
        Tone::None => exposed,
        Tone::Reinhard => {
            let scale = 1.0 / (1.0 + luminance(exposed).max(0.0));
            exposed.map(|c| c * scale)
        }
        Tone::Aces => exposed.map(|c| {
            let c = c.max(0.0);
            c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14)
        }),
        Tone::Neutral => neutral(exposed),
    };
    in_gamut(rgb)
}

/// Khronos PBR Neutral.
fn neutral(rgb: [f32; 3]) -> [f32; 3] {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let least = rgb[0].min(rgb[1]).min(rgb[2]).max(0.0);
    let offset = if least < 0.08 {
        least - 6.25 * least * least
    } else {
        0.04
    };
    let rgb = rgb.map(|c| c - offset);
    let peak = rgb[0].max(rgb[1]).max(rgb[2]);
    if peak < START {
        return rgb;
    }
    let room = 1.0 - START;
    let new_peak = 1.0 - room * room / (peak + room - START);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    rgb.map(|c| {
        let scaled = c * (new_peak / peak);
        scaled + white * (new_peak - scaled)
    })
}

/// Mixes with the gray of equal luminance, just far enough that every component lies in 0–1: the
/// report's desaturation.
#[must_use]
pub fn in_gamut(rgb: [f32; 3]) -> [f32; 3] {
    let gray = luminance(rgb).clamp(0.0, 1.0);
    let mut saturation = 1.0_f32;
    for c in rgb {
        if c < 0.0 {
            saturation = saturation.min(gray / (gray - c));
        }
        if c > 1.0 {
            saturation = saturation.min((1.0 - gray) / (c - gray));
        }
    }
    rgb.map(|c| (gray + saturation * (c - gray)).clamp(0.0, 1.0))
}

/// The sRGB encoding of a display's light, 0–1.
#[must_use]
pub fn encoded(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// Noise of a pixel, −1..1 with a triangular density, for quantization without bands.
#[must_use]
pub fn dither(x: u32, y: u32) -> f32 {
    let hash = |seed: u32| {
        let mut h = x
            .wrapping_mul(0x9E37_79B1)
            .wrapping_add(y.wrapping_mul(0x85EB_CA77))
            .wrapping_add(seed.wrapping_mul(0xC2B2_AE3D));
        h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
        h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
        h ^= h >> 15;
        // 16 bits are exact in f32
        u16::try_from(h >> 16).map_or(0.0, f32::from) / 65536.0
    };
    hash(1) - hash(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_start_at_black_rise_and_end_at_white() {
        for (tone, name) in Tone::ALL {
            let mut last = -1.0;
            for i in 0..=200_u8 {
                let x = f32::from(i) * 0.05;
                let y = luminance(tone_mapped([x, x, x], tone));
                assert!(y >= last - 1e-6 && y <= 1.0 + 1e-6, "{name} at {x}: {y}");
                last = y;
            }
            assert!(
                luminance(tone_mapped([0.0; 3], tone)).abs() < 1e-6,
                "{name}"
            );
            assert!(last > 0.85, "{name}: {last}");
        }
    }

    #[test]
    fn desaturation_keeps_the_luminance() {
        let rgb = [-0.1, 0.3, 0.9];
        let inside = in_gamut(rgb);
        assert!((luminance(inside) - luminance(rgb)).abs() < 1e-6);
        assert!(inside.iter().all(|c| (0.0..=1.0).contains(c)));
    }

    #[test]
    fn exposure_follows_the_meter() {
        // EV 15 is a meter's answer to 4096 cd/m2
        assert!((ev100_from_luminance(4096.0) - 15.0).abs() < 1e-5);
        assert!((exposure_from_ev100(15.0) * 1.2 * 32768.0 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn dither_has_no_mean_and_a_triangle_s_spread() {
        let (mut sum, mut squares) = (0.0, 0.0);
        for x in 0..256 {
            for y in 0..256 {
                let d = f64::from(dither(x, y));
                sum += d;
                squares += d * d;
            }
        }
        assert!((sum / 65536.0).abs() < 0.01);
        assert!((squares / 65536.0 - 1.0 / 6.0).abs() < 0.01);
    }
}
