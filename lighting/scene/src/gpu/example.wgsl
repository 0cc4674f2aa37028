// How much of the light from behind a grid gets through it, for each pixel of a picture.

struct Camera {
    eye: vec3<f32>,
    width: u32,
    right: vec3<f32>,
    height: u32,
    up: vec3<f32>,
    // The distance of what is behind the grid, m.
    distance: f32,
    forward: vec3<f32>,
    padding: u32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> grid: scn_Grid;
@group(0) @binding(2) var<storage> densities: array<f32>;
@group(0) @binding(3) var<storage, read_write> picture: array<vec4<f32>>;

// What the part asks for: where its data is.
fn scn_density(index: u32) -> f32 {
    return densities[index];
}

@compute @workgroup_size(8, 8)
fn look_through(@builtin(global_invocation_id) pixel: vec3<u32>) {
    if pixel.x >= camera.width || pixel.y >= camera.height {
        return;
    }
    let size = vec2(f32(camera.width), f32(camera.height));
    let screen = (2.0 * (vec2<f32>(pixel.xy) + 0.5) / size - 1.0) * vec2(1.0, -1.0);
    let direction = normalize(camera.forward + screen.x * camera.right + screen.y * camera.up);
    let depth = scn_grid_depth(grid, camera.eye, direction, 0.0, camera.distance);
    picture[pixel.y * camera.width + pixel.x] = vec4(exp(-depth * grid.tint), 1.0);
}
