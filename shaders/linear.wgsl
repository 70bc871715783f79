// For float targets: light in place of a picture. What the target cannot hold is dimmed, its color kept:
// no pixel becomes infinite.

fn displayed(light: vec3<f32>, pixel: vec2<f32>) -> vec4<f32> {
    let exposed = light * sky.exposure;
    let brightest = max(exposed.x, max(exposed.y, exposed.z));
    return vec4<f32>(exposed * min(sky.largest / max(brightest, 1e-30), 1.0), 1.0);
}
