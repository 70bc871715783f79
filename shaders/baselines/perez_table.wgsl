// Nodes of a table of a Perez form, blended; after utm_sky.wgsl and perez.wgsl. Twin:
// crates/sky-cli/src/perez_table.rs.
// baseline[0]: the sun's direction, number of nodes; [1]: radius in scale heights (0: 1/cos), root of
// its half, lowest cosine, 1 where light is blended linearly. For each node: A-D of Y, x and y; E of
// each and the weight; zenith value over F(1, sun) of each.

fn xyz_from_yxy(yxy: vec3<f32>) -> vec3<f32> {
    return yxy.x / yxy.z * vec3<f32>(yxy.y, yxy.z, 1.0 - yxy.y - yxy.z);
}

fn baseline_xyz(direction: vec3<f32>) -> vec3<f32> {
    let shape = baseline[1];
    if (direction.z < shape.z - 2e-7) {
        return vec3<f32>(0.0);
    }
    let gamma = angle_from_sun(direction, baseline[0].xz).x;
    var air_mass = 1.0 / max(direction.z, 1e-30);
    if (shape.x > 0.0) {
        air_mass = 1.0 / reciprocal_masses(direction.z, shape.xxyy).x;
    }
    let linear = shape.w > 0.5;
    var sum = vec3<f32>(0.0);
    let nodes = i32(baseline[0].w);
    for (var i = 0; i < nodes; i += 1) {
        let at = 2 + 5 * i;
        let e = baseline[at + 3];
        let light = baseline[at + 4].xyz * vec3<f32>(
            perez(baseline[at], e.x, air_mass, gamma),
            perez(baseline[at + 1], e.y, air_mass, gamma),
            perez(baseline[at + 2], e.z, air_mass, gamma),
        );
        if (linear) {
            sum += e.w * xyz_from_yxy(light);
        } else {
            sum += e.w * vec3<f32>(log(light.x), light.yz);
        }
    }
    if (linear) {
        return sum;
    }
    return xyz_from_yxy(vec3<f32>(exp(sum.x), sum.yz));
}
