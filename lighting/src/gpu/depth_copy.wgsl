// From the texture of a tile to the buffer of the map.

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var rendered: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> map: array<f32>;

@compute @workgroup_size(8, 8)
fn copy(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= tile.size) {
        return;
    }
    let at = tile.first + id.xy;
    let index = (tile.index * tile.resolution + at.y) * tile.resolution + at.x;
    map[index] = textureLoad(rendered, id.xy, 0).x;
}
