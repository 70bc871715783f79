// Yxy to linear sRGB. Twin: crates/sky-core/src/color.rs.

fn linear_srgb_from_yxy(yxy: vec3<f32>) -> vec3<f32> {
    let scale = yxy.x / yxy.z;
    let xyz = vec3<f32>(yxy.y * scale, yxy.x, (1.0 - yxy.y - yxy.z) * scale);
    return vec3<f32>(
        dot(vec3<f32>(3.24096994, -1.53738318, -0.49861076), xyz),
        dot(vec3<f32>(-0.96924364, 1.87596750, 0.04155506), xyz),
        dot(vec3<f32>(0.05563008, -0.20397696, 1.05697151), xyz),
    );
}

fn luminance_of(rgb: vec3<f32>) -> f32 {
    return dot(vec3<f32>(0.212639, 0.7151687, 0.07219232), rgb);
}
