// A table that is bound by itself. Needs the variables
//   air_table: air_Table
//   air_cells: array<vec4<u32>>

fn air_table_uniforms() -> air_Table {
    return air_table;
}

fn air_table_cell(index: u32) -> vec4<u32> {
    return air_cells[index];
}
