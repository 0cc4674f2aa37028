// What is in the way of the lamp's light: boxes, as the renderer's own rays find them.

struct example_Box {
    low: vec4<f32>,
    high: vec4<f32>,
}

fn example_boxes_first_blocker_of(tile: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    var nearest = epi_INFINITE;
    for (var i = 0u; i < 16u; i += 1u) {
        let a = (example_boxes[i].low.xyz - origin) / direction;
        let b = (example_boxes[i].high.xyz - origin) / direction;
        let enter = min(a, b);
        let leave = max(a, b);
        let distance = max(enter.x, max(enter.y, enter.z));
        if distance > 0.0 && distance < min(leave.x, min(leave.y, leave.z)) {
            nearest = min(nearest, distance);
        }
    }
    return nearest;
}
