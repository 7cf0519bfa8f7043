/* FMI 2.0's definitions of the names used in the rest of the file. */
typedef fmi2Status plcfmu_status_t;
typedef fmi2ValueReference plcfmu_reference_t;
typedef fmi2CallbackLogger plcfmu_logger_t;
#define PLCFMU_OK fmi2OK
#define PLCFMU_REFUSED fmi2Error
#define PLCFMU_PREFIX "fmi2"
#define PLCFMU_REFERENCES_NAME "vr"
#define PLCFMU_VALUES_NAME "value"
#define PLCFMU_STATE_NAME "FMUstate"
#define PLCFMU_INSTANTIATE PLCFMU_OF_Instantiate
#define PLCFMU_INSTANTIATE_NAME "fmi2Instantiate"

static void plcfmu_log(plcfmu_logger_t logger, void *environment, const char *name, plcfmu_status_t status, const char *category,
                       const char *text) {
    logger(environment, name, status, category, "%s", text);
}
