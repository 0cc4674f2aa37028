// Visibility: where both of two sources are lit, with the product of their shares;
// the shader's side of `Both`.
//
// Needs the slots of the two,
//   alias light_both_FirstCursor, light_both_SecondCursor
//   fn light_both_first(path: light_Path) -> light_both_FirstCursor
//   fn light_both_second(path: light_Path) -> light_both_SecondCursor
//   fn light_both_next_first(cursor: ptr<function, light_both_FirstCursor>, path: light_Path) -> light_Lit
//   fn light_both_next_second(cursor: ptr<function, light_both_SecondCursor>, path: light_Path) -> light_Lit

struct light_both_Cursor {
    first: light_both_FirstCursor,
    second: light_both_SecondCursor,
    // The lit part of each source that the position is in or in front of.
    a: light_Lit,
    b: light_Lit,
}

fn light_both_cursor(path: light_Path) -> light_both_Cursor {
    var first = light_both_first(path);
    var second = light_both_second(path);
    let a = light_both_next_first(&first, path);
    let b = light_both_next_second(&second, path);
    return light_both_Cursor(first, second, a, b);
}

fn light_both_next_lit(cursor: ptr<function, light_both_Cursor>, path: light_Path) -> light_Lit {
    loop {
        let a = (*cursor).a;
        let b = (*cursor).b;
        if light_is_dark(a) || light_is_dark(b) {
            break;
        }
        // The part that ends first overlaps nothing further on.
        if a.end < b.end {
            var first = (*cursor).first;
            (*cursor).a = light_both_next_first(&first, path);
            (*cursor).first = first;
        } else {
            var second = (*cursor).second;
            (*cursor).b = light_both_next_second(&second, path);
            (*cursor).second = second;
        }
        let overlap = light_Lit(max(a.start, b.start), min(a.end, b.end), a.visibility * b.visibility);
        if overlap.start < overlap.end && !light_is_dark(overlap) {
            return overlap;
        }
    }
    return light_dark();
}
