// Visibility: nothing is in the way of the light.

struct light_unshadowed_Cursor {
    done: bool,
}

fn light_unshadowed_cursor(path: light_Path) -> light_unshadowed_Cursor {
    return light_unshadowed_Cursor(false);
}

fn light_unshadowed_next_lit(
    cursor: ptr<function, light_unshadowed_Cursor>,
    path: light_Path,
) -> light_Lit {
    if (*cursor).done {
        return light_dark();
    }
    (*cursor).done = true;
    return light_lit(path.start, path.end, 1.0);
}
