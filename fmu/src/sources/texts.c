
/* --- Texts: a STRING has one byte per character, in ISO 8859-1; a WSTRING is UTF-16; a host uses UTF-8 */

static u32_t plcfmu_unit(const plcfmu_text_row_t *row, const memory_t *memory, u32_t at) {
    const char *characters = (const char *)memory + row->offset + 2;
    u16_t wide;
    if (!row->is_wide) {
        return (unsigned char)characters[at];
    }
    memcpy(&wide, characters + 2 * (size_t)at, sizeof wide);
    return wide;
}

/* Converts the text to UTF-8. It ends before the first NUL character. Unpaired UTF-16 surrogates become U+FFFD. */
static void plcfmu_encode(const plcfmu_text_row_t *row, const memory_t *memory, char *to) {
    u16_t length;
    u32_t at;
    memcpy(&length, (const char *)memory + row->offset, sizeof length);
    for (at = 0; at < length && at < row->most; at += 1) {
        u32_t code = plcfmu_unit(row, memory, at);
        if (code == 0) {
            break;
        }
        if (code >= 0xD800 && code <= 0xDFFF) {
            u32_t low = code <= 0xDBFF && at + 1 < length && at + 1 < row->most ? plcfmu_unit(row, memory, at + 1) : 0;
            int is_pair = low >= 0xDC00 && low <= 0xDFFF;
            code = is_pair ? 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00) : 0xFFFD;
            at += is_pair ? 1u : 0u;
        }
        if (code < 0x80) {
            *to++ = (char)code;
        } else if (code < 0x800) {
            *to++ = (char)(0xC0 | (code >> 6));
            *to++ = (char)(0x80 | (code & 0x3F));
        } else if (code < 0x10000) {
            *to++ = (char)(0xE0 | (code >> 12));
            *to++ = (char)(0x80 | ((code >> 6) & 0x3F));
            *to++ = (char)(0x80 | (code & 0x3F));
        } else {
            *to++ = (char)(0xF0 | (code >> 18));
            *to++ = (char)(0x80 | ((code >> 12) & 0x3F));
            *to++ = (char)(0x80 | ((code >> 6) & 0x3F));
            *to++ = (char)(0x80 | (code & 0x3F));
        }
    }
    *to = '\0';
}

/* Decodes the next character of a UTF-8 text and returns its number of bytes; 0 if it is invalid. */
static size_t plcfmu_decode(const char *from, u32_t *code) {
    static const u32_t least[4] = {0, 0x80, 0x800, 0x10000};
    unsigned char first = (unsigned char)from[0];
    size_t more = first < 0x80 ? 0 : first >= 0xC2 && first < 0xE0 ? 1 : first >= 0xE0 && first < 0xF0 ? 2 : 3, i;
    if (first >= 0x80 && (first < 0xC2 || first > 0xF4)) {
        return 0;
    }
    *code = more == 0 ? first : first & (0x3Fu >> more);
    for (i = 1; i <= more; i += 1) {
        if (((unsigned char)from[i] & 0xC0) != 0x80) {
            return 0;
        }
        *code = (*code << 6) | ((unsigned char)from[i] & 0x3F);
    }
    return *code < least[more] || *code > 0x10FFFF || (*code >= 0xD800 && *code <= 0xDFFF) ? 0 : more + 1;
}

static const plcfmu_text_row_t *plcfmu_text_row(plcfmu_component_t *c, u32_t reference, const char *access) {
    if (reference < PLCFMU_ROWS || reference - PLCFMU_ROWS >= PLCFMU_TEXTS) {
        plcfmu_no_variable(&c->text, reference, access);
        return NULL;
    }
    return &plcfmu_text_rows[reference - PLCFMU_ROWS];
}

static plcfmu_status_t plcfmu_get_strings(plcfmu_component_t *c, const plcfmu_reference_t vr[], size_t count, const char *value[]) {
    const plcfmu_block_t *block = &c->instance.block;
    plcfmu_walk_t walk = plcfmu_walk(vr, count);
    int is_asked = 0;
    u32_t reference;
    size_t i;
    if (plcfmu_array(&c->text, vr, count, sizeof *vr, PLCFMU_REFERENCES_NAME) != PLCFMU_OK
        || plcfmu_array(&c->text, value, count, sizeof(const char *), PLCFMU_VALUES_NAME) != PLCFMU_OK) {
        return PLCFMU_REFUSED;
    }
    while (plcfmu_next_value(&walk, &reference)) {
        const plcfmu_text_row_t *row = plcfmu_text_row(c, reference, "Get");
        if (row == NULL) {
            return PLCFMU_REFUSED;
        }
        is_asked |= !plcfmu_is_given(row);
    }
    if (is_asked && c->instance.state == PLCFMU_INITIALIZATION) {
        block = plcfmu_restarted(c);
    }
    walk = plcfmu_walk(vr, count);
    for (i = 0; plcfmu_next_value(&walk, &reference); i += 1) {
        const plcfmu_text_row_t *row = &plcfmu_text_rows[reference - PLCFMU_ROWS];
        char *text = c->given + row->given;
        plcfmu_encode(row, plcfmu_is_given(row) ? &c->instance.block.memory : &block->memory, text);
        value[i] = text;
    }
    return PLCFMU_OK;
}

/* Checks that a text can be set; otherwise, rejects it with the reason. */
static plcfmu_status_t plcfmu_check_text(plcfmu_component_t *c, const plcfmu_text_row_t *row, const char *given) {
    u32_t units = 0, code = 0;
    const char *at, *outside = NULL;
    size_t size = 1;
    plcfmu_text_t value = {0, {0}}, why = {0, {0}};
    if (!plcfmu_is_given(row)) {
        return plcfmu_say_computed(&c->text, row->name);
    }
    if (given == NULL) {
        return plcfmu_say_no_text(&c->text, row->name);
    }
    for (at = given; *at != '\0' && size != 0; at += size) {
        size = plcfmu_decode(at, &code);
        units += code > 0xFFFF ? 2u : 1u;
        outside = outside == NULL && code > 0xFF && !row->is_wide ? at : outside;
    }
    if (size != 0 && units <= row->most && outside == NULL) {
        return PLCFMU_OK;
    }
    if (size == 0) {
        return plcfmu_say_not_utf8(&c->text, row->name, (size_t)(at - given));
    }
    plcfmu_say_quoted(&value, given);
    if (units > row->most) {
        plcfmu_say(&why, row->type);
        plcfmu_say(&why, " holds at most ");
        plcfmu_say_whole(&why, row->most);
        plcfmu_say(&why, " characters, not ");
        plcfmu_say_whole(&why, units);
    } else {
        char character[5] = {0, 0, 0, 0, 0};
        memcpy(character, outside, plcfmu_decode(outside, &code));
        plcfmu_say(&why, "a STRING holds only ISO 8859-1 characters, and '");
        plcfmu_say(&why, character);
        plcfmu_say(&why, "' is not one of them");
    }
    return plcfmu_say_out_of_range(&c->text, row->name, value.text, why.text);
}

static void plcfmu_put_text(const plcfmu_text_row_t *row, memory_t *memory, const char *given) {
    char *to = (char *)memory + row->offset;
    u16_t length = 0;
    u32_t code = 0;
    for (; *given != '\0'; given += plcfmu_decode(given, &code), length = (u16_t)(length + 1)) {
        u16_t unit;
        plcfmu_decode(given, &code);
        unit = (u16_t)code;
        if (code > 0xFFFF) {
            unit = (u16_t)(0xD800 + ((code - 0x10000) >> 10));
            memcpy(to + 2 + 2 * (size_t)length, &unit, sizeof unit);
            length = (u16_t)(length + 1);
            unit = (u16_t)(0xDC00 + ((code - 0x10000) & 0x3FF));
        }
        if (row->is_wide) {
            memcpy(to + 2 + 2 * (size_t)length, &unit, sizeof unit);
        } else {
            to[2 + length] = (char)(unsigned char)unit;
        }
    }
    memcpy(to, &length, sizeof length);
}

static plcfmu_status_t plcfmu_set_strings(plcfmu_component_t *c, const plcfmu_reference_t vr[], size_t count,
                                     const char *const value[]) {
    plcfmu_walk_t walk = plcfmu_walk(vr, count);
    u32_t reference;
    size_t i;
    if (plcfmu_array(&c->text, vr, count, sizeof *vr, PLCFMU_REFERENCES_NAME) != PLCFMU_OK
        || plcfmu_array(&c->text, value, count, sizeof(const char *), PLCFMU_VALUES_NAME) != PLCFMU_OK) {
        return PLCFMU_REFUSED;
    }
    for (i = 0; plcfmu_next_value(&walk, &reference); i += 1) {
        const plcfmu_text_row_t *row = plcfmu_text_row(c, reference, "Set");
        if (row == NULL || plcfmu_check_text(c, row, value[i]) != PLCFMU_OK) {
            return PLCFMU_REFUSED;
        }
    }
    walk = plcfmu_walk(vr, count);
    for (i = 0; plcfmu_next_value(&walk, &reference); i += 1) {
        plcfmu_put_text(&plcfmu_text_rows[reference - PLCFMU_ROWS], &c->instance.block.memory, value[i]);
    }
    return PLCFMU_OK;
}
