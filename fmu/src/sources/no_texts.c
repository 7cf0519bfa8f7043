
/* --- No String variables */

static plcfmu_status_t plcfmu_strings(plcfmu_component_t *c, const plcfmu_reference_t vr[], size_t count, const void *value,
                                 const char *access) {
    if (plcfmu_array(&c->text, vr, count, sizeof *vr, PLCFMU_REFERENCES_NAME) != PLCFMU_OK
        || plcfmu_array(&c->text, value, count, sizeof(const char *), PLCFMU_VALUES_NAME) != PLCFMU_OK) {
        return PLCFMU_REFUSED;
    }
    return count == 0 ? PLCFMU_OK : plcfmu_no_variable(&c->text, vr[0], access);
}

static plcfmu_status_t plcfmu_get_strings(plcfmu_component_t *c, const plcfmu_reference_t vr[], size_t count, const char *value[]) {
    return plcfmu_strings(c, vr, count, value, "Get");
}

static plcfmu_status_t plcfmu_set_strings(plcfmu_component_t *c, const plcfmu_reference_t vr[], size_t count,
                                     const char *const value[]) {
    return plcfmu_strings(c, vr, count, value, "Set");
}
