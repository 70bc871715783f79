// Noise of a pixel, -1 to 1 with a triangular density. Twin: dither in crates/sky-core/src/tonemap.rs.

fn hash_noise(x: u32, y: u32, seed: u32) -> f32 {
    var h = x * 0x9E3779B1u + y * 0x85EBCA77u + seed * 0xC2B2AE3Du;
    h = (h ^ (h >> 15u)) * 0x2C1B3C6Du;
    h = (h ^ (h >> 12u)) * 0x297A2D39u;
    h = h ^ (h >> 15u);
    return f32(h >> 16u) / 65536.0;
}

fn dither(pixel: vec2<f32>) -> f32 {
    let x = u32(pixel.x);
    let y = u32(pixel.y);
    return hash_noise(x, y, 1u) - hash_noise(x, y, 2u);
}
