// A table in a group of its own.

@group(1) @binding(0) var<uniform> air_table: air_Table;
@group(1) @binding(1) var<storage> air_cells: array<vec4<u32>>;

fn air_table_uniforms() -> air_Table {
    return air_table;
}

fn air_table_cell(index: u32) -> vec4<u32> {
    return air_cells[index];
}

fn air_airlight(sigma_t: f32, segment: air_Segment) -> f32 {
    return air_table_airlight(sigma_t, segment);
}
