// Exposure, tone curve, gamut, encoding, dither. Twin: crates/sky-core/src/tonemap.rs.

fn neutral(color: vec3<f32>) -> vec3<f32> {
    let start = 0.8 - 0.04;
    let least = max(min(color.x, min(color.y, color.z)), 0.0);
    let offset = select(0.04, least - 6.25 * least * least, least < 0.08);
    let rgb = color - offset;
    let peak = max(rgb.x, max(rgb.y, rgb.z));
    if (peak < start) {
        return rgb;
    }
    let room = 1.0 - start;
    let new_peak = 1.0 - room * room / (peak + room - start);
    let white = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    let scaled = rgb * (new_peak / peak);
    return scaled + white * (new_peak - scaled);
}

fn gamut_share(gray: f32, c: f32) -> f32 {
    if (c < 0.0) {
        return gray / (gray - c);
    }
    if (c > 1.0) {
        return (1.0 - gray) / (c - gray);
    }
    return 1.0;
}

fn in_gamut(rgb: vec3<f32>) -> vec3<f32> {
    let gray = clamp(luminance_of(rgb), 0.0, 1.0);
    let saturation = min(min(gamut_share(gray, rgb.x), gamut_share(gray, rgb.y)), gamut_share(gray, rgb.z));
    return clamp(gray + saturation * (rgb - gray), vec3<f32>(0.0, 0.0, 0.0), vec3<f32>(1.0, 1.0, 1.0));
}

fn tone_mapped(exposed: vec3<f32>, tone: f32) -> vec3<f32> {
    if (tone < 0.5) {
        return in_gamut(exposed);
    }
    if (tone < 1.5) {
        return in_gamut(exposed / (1.0 + max(luminance_of(exposed), 0.0)));
    }
    if (tone < 2.5) {
        let c = max(exposed, vec3<f32>(0.0, 0.0, 0.0));
        return in_gamut(c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14));
    }
    return in_gamut(neutral(exposed));
}

fn encoded(linear: vec3<f32>) -> vec3<f32> {
    let low = 12.92 * linear;
    let high = 1.055 * pow(max(linear, vec3<f32>(0.0031308, 0.0031308, 0.0031308)), vec3<f32>(1.0 / 2.4, 1.0 / 2.4, 1.0 / 2.4)) - 0.055;
    return select(high, low, linear <= vec3<f32>(0.0031308, 0.0031308, 0.0031308));
}

// The pixel of a display, with noise that hides its levels.
fn displayed(light: vec3<f32>, pixel: vec2<f32>) -> vec4<f32> {
    let linear = tone_mapped(light * sky.exposure, sky.tone);
    let noise = dither(pixel) * sky.dither_step;
    if (sky.target_encodes > 0.5) {
        // the target's own encoding follows: noise as steep as its inverse there
        return vec4<f32>(linear + noise * (0.077 + 2.2 * pow(linear, vec3<f32>(0.55, 0.55, 0.55))), 1.0);
    }
    return vec4<f32>(encoded(linear) + noise, 1.0);
}
