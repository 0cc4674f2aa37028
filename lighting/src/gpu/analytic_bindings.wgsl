// Where the table finds its cells when this crate assembles the shader.

@group(2) @binding(2) var<uniform> table: air_Table;
@group(2) @binding(3) var<storage> table_cells: array<vec4<u32>>;

fn air_table_uniforms() -> air_Table {
    return table;
}

fn air_table_cell(index: u32) -> vec4<u32> {
    return table_cells[index];
}
