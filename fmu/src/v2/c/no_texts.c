
/* --- There are no String variables */

static fmi2Status plcfmu_strings(plcfmu_component_t *c, const fmi2ValueReference vr[], size_t count, const void *value,
                                 const char *access) {
    if (plcfmu_array(&c->text, vr, count, sizeof *vr, "vr") != fmi2OK
        || plcfmu_array(&c->text, value, count, sizeof(fmi2String), "value") != fmi2OK) {
        return fmi2Error;
    }
    return count == 0 ? fmi2OK : plcfmu_no_variable(&c->text, vr[0], access);
}

static fmi2Status plcfmu_get_strings(plcfmu_component_t *c, const fmi2ValueReference vr[], size_t count, fmi2String value[]) {
    return plcfmu_strings(c, vr, count, value, "Get");
}

static fmi2Status plcfmu_set_strings(plcfmu_component_t *c, const fmi2ValueReference vr[], size_t count,
                                     const fmi2String value[]) {
    return plcfmu_strings(c, vr, count, value, "Set");
}
