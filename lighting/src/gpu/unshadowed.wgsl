// Visibility: nothing is in the way.

struct light_Look {
    done: bool,
}

fn light_look(path: light_Path) -> light_Look {
    return light_Look(false);
}

fn light_next_lit(look: ptr<function, light_Look>, path: light_Path) -> light_Lit {
    if (*look).done {
        return light_Lit(0.0, 0.0, 0.0);
    }
    (*look).done = true;
    return light_Lit(path.start, path.end, 1.0);
}
