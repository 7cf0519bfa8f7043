/* FMI 3.0's definitions of the names used in the rest of the file. */
typedef fmi3Status plcfmu_status_t;
typedef fmi3ValueReference plcfmu_reference_t;
typedef fmi3LogMessageCallback plcfmu_logger_t;
#define PLCFMU_OK fmi3OK
#define PLCFMU_REFUSED fmi3Error
#define PLCFMU_PREFIX "fmi3"
#define PLCFMU_REFERENCES_NAME "valueReferences"
#define PLCFMU_VALUES_NAME "values"
#define PLCFMU_STATE_NAME "FMUState"
#define PLCFMU_INSTANTIATE PLCFMU_OF_InstantiateCoSimulation
#define PLCFMU_INSTANTIATE_NAME "fmi3InstantiateCoSimulation"

static void plcfmu_log(plcfmu_logger_t logger, void *environment, const char *name, plcfmu_status_t status, const char *category,
                       const char *text) {
    (void)name;
    if (logger != NULL) {
        logger(environment, status, category, text);
    }
}
