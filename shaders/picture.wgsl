// The light of sky and ground, and what the air does to an object's light. Twin:
// crates/sky-core/src/picture.rs.

// Light from a unit vector in the local frame at or above the horizon, without the sun's disc.
fn sky_light(direction: vec3<f32>) -> vec3<f32> {
    let angles = angle_from_sun(direction, sky.sun_sin_cos);
    let light = linear_srgb_from_yxy(sky_yxy(direction.z, angles.x, angles.y));
    return select(light, outside_domain(direction), sky.outside_domain > 0.5);
}

// Light from below the horizon: the ground through the air.
fn ground_light(direction: vec3<f32>) -> vec3<f32> {
    let distance = distance_to_ground(sky.altitude_km, direction.z);
    let light = behind_air(direction, distance, sky.ground);
    return select(light, outside_domain(direction), sky.outside_domain > 0.5);
}

// An object's light [cd/m2] in a local direction at a distance [km], through the air before it.
fn behind_air(direction: vec3<f32>, distance_km: f32, object: vec3<f32>) -> vec3<f32> {
    let path = aerial_path(sky.altitude_km, direction, distance_km);
    return path.transmittance.xyz * object + path.inscatter;
}

// The air between the observer and a place, given from the observer in the world's units.
fn air_before(place: vec3<f32>, km_per_unit: f32) -> AerialPath {
    return aerial_path(sky.altitude_km, to_local(place), length(place) * km_per_unit);
}

fn is_sky(direction: vec3<f32>) -> bool {
    return direction.z >= sky.cos_horizon - HORIZON_SLACK;
}

// Stripes that nobody takes for a sky.
fn outside_domain(direction: vec3<f32>) -> vec3<f32> {
    let stripe = select(0.1, 1.0, fract((direction.x + direction.y + direction.z) * 8.0) < 0.5);
    return vec3<f32>(stripe, 0.0, stripe) / max(sky.exposure, 1e-9);
}
