// Full-screen skies for a processor that plays GPU: there, reading a number of a uniform costs as much
// as ten products, and a number from the vertex stage almost nothing. So the vertices carry what they
// can: 56 of the 66 coefficients for the tier fragment, the sun for the tier baked.

struct FlatVertex {
    @builtin(position) position: vec4<f32>,
    // in the local frame, of any length
    @location(0) ray: vec3<f32>,
    @location(1) @interpolate(flat) c0: vec4<f32>,
    @location(2) @interpolate(flat) c1: vec4<f32>,
    @location(3) @interpolate(flat) c2: vec4<f32>,
    @location(4) @interpolate(flat) c3: vec4<f32>,
    @location(5) @interpolate(flat) c4: vec4<f32>,
    @location(6) @interpolate(flat) c5: vec4<f32>,
    @location(7) @interpolate(flat) c6: vec4<f32>,
    @location(8) @interpolate(flat) c7: vec4<f32>,
    @location(9) @interpolate(flat) c8: vec4<f32>,
    @location(10) @interpolate(flat) c9: vec4<f32>,
    @location(11) @interpolate(flat) c10: vec4<f32>,
    @location(12) @interpolate(flat) c11: vec4<f32>,
    @location(13) @interpolate(flat) c12: vec4<f32>,
    @location(14) @interpolate(flat) c13: vec4<f32>,
}

struct FlatBakedVertex {
    @builtin(position) position: vec4<f32>,
    @location(0) ray: vec3<f32>,
    @location(1) @interpolate(flat) place: vec4<f32>,
    @location(2) @interpolate(flat) upper: vec4<f32>,
    @location(3) @interpolate(flat) lower: vec4<f32>,
    @location(4) @interpolate(flat) scale: f32,
}

var<private> flat_coefficients: array<vec4<f32>, 22>;
var<private> flat_place: vec4<f32>;
var<private> flat_upper: vec4<f32>;
var<private> flat_lower: vec4<f32>;
var<private> flat_scale: f32;

fn coefficient(k: u32) -> vec4<f32> {
    return flat_coefficients[k];
}

fn place_of_sun() -> vec4<f32> {
    return flat_place;
}

fn upper_limb() -> vec4<f32> {
    return flat_upper;
}

fn lower_limb() -> vec4<f32> {
    return flat_lower;
}

fn baked_scale() -> f32 {
    return flat_scale;
}

@vertex
fn flat_vertex(@builtin(vertex_index) index: u32) -> FlatVertex {
    let corner = screen_corner(index);
    var out: FlatVertex;
    out.position = corner.position;
    out.ray = corner.ray;
    out.c0 = vec4<f32>(sky.coefficients[0].x, sky.coefficients[0].y, sky.coefficients[0].z, sky.coefficients[1].x);
    out.c1 = vec4<f32>(sky.coefficients[1].y, sky.coefficients[1].z, sky.coefficients[2].x, sky.coefficients[2].y);
    out.c2 = vec4<f32>(sky.coefficients[2].z, sky.coefficients[3].x, sky.coefficients[3].y, sky.coefficients[3].z);
    out.c3 = vec4<f32>(sky.coefficients[4].x, sky.coefficients[4].y, sky.coefficients[4].z, sky.coefficients[5].x);
    out.c4 = vec4<f32>(sky.coefficients[5].y, sky.coefficients[5].z, sky.coefficients[6].x, sky.coefficients[6].y);
    out.c5 = vec4<f32>(sky.coefficients[6].z, sky.coefficients[7].x, sky.coefficients[7].y, sky.coefficients[7].z);
    out.c6 = vec4<f32>(sky.coefficients[8].x, sky.coefficients[8].y, sky.coefficients[8].z, sky.coefficients[9].x);
    out.c7 = vec4<f32>(sky.coefficients[9].y, sky.coefficients[9].z, sky.coefficients[10].x, sky.coefficients[10].y);
    out.c8 = vec4<f32>(sky.coefficients[10].z, sky.coefficients[11].x, sky.coefficients[11].y, sky.coefficients[11].z);
    out.c9 = vec4<f32>(sky.coefficients[12].x, sky.coefficients[12].y, sky.coefficients[12].z, sky.coefficients[13].x);
    out.c10 = vec4<f32>(sky.coefficients[13].y, sky.coefficients[13].z, sky.coefficients[14].x, sky.coefficients[14].y);
    out.c11 = vec4<f32>(sky.coefficients[14].z, sky.coefficients[15].x, sky.coefficients[15].y, sky.coefficients[15].z);
    out.c12 = vec4<f32>(sky.coefficients[16].x, sky.coefficients[16].y, sky.coefficients[16].z, sky.coefficients[17].x);
    out.c13 = vec4<f32>(sky.coefficients[17].y, sky.coefficients[17].z, sky.coefficients[18].x, sky.coefficients[18].y);
    return out;
}

@fragment
fn flat_fragment(in: FlatVertex) -> @location(0) vec4<f32> {
    flat_coefficients[0] = vec4<f32>(in.c0.x, in.c0.y, in.c0.z, 0.0);
    flat_coefficients[1] = vec4<f32>(in.c0.w, in.c1.x, in.c1.y, 0.0);
    flat_coefficients[2] = vec4<f32>(in.c1.z, in.c1.w, in.c2.x, 0.0);
    flat_coefficients[3] = vec4<f32>(in.c2.y, in.c2.z, in.c2.w, 0.0);
    flat_coefficients[4] = vec4<f32>(in.c3.x, in.c3.y, in.c3.z, 0.0);
    flat_coefficients[5] = vec4<f32>(in.c3.w, in.c4.x, in.c4.y, 0.0);
    flat_coefficients[6] = vec4<f32>(in.c4.z, in.c4.w, in.c5.x, 0.0);
    flat_coefficients[7] = vec4<f32>(in.c5.y, in.c5.z, in.c5.w, 0.0);
    flat_coefficients[8] = vec4<f32>(in.c6.x, in.c6.y, in.c6.z, 0.0);
    flat_coefficients[9] = vec4<f32>(in.c6.w, in.c7.x, in.c7.y, 0.0);
    flat_coefficients[10] = vec4<f32>(in.c7.z, in.c7.w, in.c8.x, 0.0);
    flat_coefficients[11] = vec4<f32>(in.c8.y, in.c8.z, in.c8.w, 0.0);
    flat_coefficients[12] = vec4<f32>(in.c9.x, in.c9.y, in.c9.z, 0.0);
    flat_coefficients[13] = vec4<f32>(in.c9.w, in.c10.x, in.c10.y, 0.0);
    flat_coefficients[14] = vec4<f32>(in.c10.z, in.c10.w, in.c11.x, 0.0);
    flat_coefficients[15] = vec4<f32>(in.c11.y, in.c11.z, in.c11.w, 0.0);
    flat_coefficients[16] = vec4<f32>(in.c12.x, in.c12.y, in.c12.z, 0.0);
    flat_coefficients[17] = vec4<f32>(in.c12.w, in.c13.x, in.c13.y, 0.0);
    flat_coefficients[18] = vec4<f32>(in.c13.z, in.c13.w, sky.coefficients[18].z, 0.0);
    flat_coefficients[19] = sky.coefficients[19];
    flat_coefficients[20] = sky.coefficients[20];
    flat_coefficients[21] = sky.coefficients[21];
    flat_place = vec4<f32>(sky.place.xyz, sky.ground.w);
    flat_upper = sky.sun_upper;
    flat_lower = sky.sun_lower;
    flat_scale = sky.debug.z;
    return displayed(light_from(normalize(in.ray)), in.position.xy, sky.display);
}

@vertex
fn flat_baked_vertex(@builtin(vertex_index) index: u32) -> FlatBakedVertex {
    let corner = screen_corner(index);
    var out: FlatBakedVertex;
    out.position = corner.position;
    out.ray = corner.ray;
    out.place = vec4<f32>(sky.place.xyz, sky.ground.w);
    out.upper = sky.sun_upper;
    out.lower = sky.sun_lower;
    out.scale = sky.debug.z;
    return out;
}

@fragment
fn flat_baked_fragment(in: FlatBakedVertex) -> @location(0) vec4<f32> {
    flat_place = in.place;
    flat_upper = in.upper;
    flat_lower = in.lower;
    flat_scale = in.scale;
    let direction = normalize(in.ray);
    return displayed(baked_light(direction) + sun_disc(direction), in.position.xy, sky.display);
}
