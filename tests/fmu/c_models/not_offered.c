/* All functions of FMI 2.0 and 3.0 for the models here, which bring their own of those that they offer: these are weak.
   Entering, leaving and ending do nothing, instances are freed, and what is not offered answers an error. */

#include <stdlib.h>

#define WEAK __attribute__((weak))
#define TEXT(name, text) WEAK const char *name(void) { return text; }
#define NOTHING(name) WEAK int name(void) { return 0; }
#define NOT_OFFERED(name) WEAK int name(void) { return 3; }

TEXT(fmi2GetVersion, "2.0") TEXT(fmi2GetTypesPlatform, "default") TEXT(fmi3GetVersion, "3.0")
WEAK void fmi2FreeInstance(void *m) { free(m); }
WEAK void fmi3FreeInstance(void *m) { free(m); }
WEAK void *fmi3InstantiateModelExchange(void) { return NULL; }
WEAK void *fmi3InstantiateScheduledExecution(void) { return NULL; }
NOTHING(fmi2EnterInitializationMode) NOTHING(fmi2ExitInitializationMode) NOTHING(fmi2SetupExperiment)
NOTHING(fmi2Terminate)
NOTHING(fmi3EnterInitializationMode) NOTHING(fmi3ExitInitializationMode) NOTHING(fmi3Terminate)
NOT_OFFERED(fmi2CancelStep) NOT_OFFERED(fmi2DeSerializeFMUstate) NOT_OFFERED(fmi2DoStep) NOT_OFFERED(fmi2FreeFMUstate)
NOT_OFFERED(fmi2GetBoolean) NOT_OFFERED(fmi2GetBooleanStatus) NOT_OFFERED(fmi2GetDirectionalDerivative)
NOT_OFFERED(fmi2GetFMUstate) NOT_OFFERED(fmi2GetInteger) NOT_OFFERED(fmi2GetIntegerStatus) NOT_OFFERED(fmi2GetReal)
NOT_OFFERED(fmi2GetRealOutputDerivatives) NOT_OFFERED(fmi2GetRealStatus) NOT_OFFERED(fmi2GetStatus)
NOT_OFFERED(fmi2GetString) NOT_OFFERED(fmi2GetStringStatus) NOT_OFFERED(fmi2Reset) NOT_OFFERED(fmi2SerializeFMUstate)
NOT_OFFERED(fmi2SerializedFMUstateSize) NOT_OFFERED(fmi2SetBoolean) NOT_OFFERED(fmi2SetDebugLogging)
NOT_OFFERED(fmi2SetFMUstate) NOT_OFFERED(fmi2SetInteger) NOT_OFFERED(fmi2SetReal)
NOT_OFFERED(fmi2SetRealInputDerivatives) NOT_OFFERED(fmi2SetString)
NOT_OFFERED(fmi3ActivateModelPartition) NOT_OFFERED(fmi3Boolean) NOT_OFFERED(fmi3CompletedIntegratorStep)
NOT_OFFERED(fmi3DeserializeFMUState) NOT_OFFERED(fmi3DoStep) NOT_OFFERED(fmi3EnterConfigurationMode)
NOT_OFFERED(fmi3EnterContinuousTimeMode) NOT_OFFERED(fmi3EnterEventMode) NOT_OFFERED(fmi3EnterStepMode)
NOT_OFFERED(fmi3EvaluateDiscreteStates) NOT_OFFERED(fmi3ExitConfigurationMode) NOT_OFFERED(fmi3Float32)
NOT_OFFERED(fmi3FreeFMUState) NOT_OFFERED(fmi3GetAdjointDerivative) NOT_OFFERED(fmi3GetBinary)
NOT_OFFERED(fmi3GetBoolean) NOT_OFFERED(fmi3GetClock) NOT_OFFERED(fmi3GetContinuousStateDerivatives)
NOT_OFFERED(fmi3GetContinuousStates) NOT_OFFERED(fmi3GetDirectionalDerivative) NOT_OFFERED(fmi3GetEventIndicators)
NOT_OFFERED(fmi3GetFMUState) NOT_OFFERED(fmi3GetFloat32) NOT_OFFERED(fmi3GetFloat64) NOT_OFFERED(fmi3GetInt16)
NOT_OFFERED(fmi3GetInt32) NOT_OFFERED(fmi3GetInt64) NOT_OFFERED(fmi3GetInt8) NOT_OFFERED(fmi3GetIntervalDecimal)
NOT_OFFERED(fmi3GetIntervalFraction) NOT_OFFERED(fmi3GetNominalsOfContinuousStates)
NOT_OFFERED(fmi3GetNumberOfContinuousStates) NOT_OFFERED(fmi3GetNumberOfEventIndicators)
NOT_OFFERED(fmi3GetNumberOfVariableDependencies) NOT_OFFERED(fmi3GetOutputDerivatives)
NOT_OFFERED(fmi3GetShiftDecimal) NOT_OFFERED(fmi3GetShiftFraction) NOT_OFFERED(fmi3GetString)
NOT_OFFERED(fmi3GetUInt16) NOT_OFFERED(fmi3GetUInt32) NOT_OFFERED(fmi3GetUInt64) NOT_OFFERED(fmi3GetUInt8)
NOT_OFFERED(fmi3GetVariableDependencies) NOT_OFFERED(fmi3Int16) NOT_OFFERED(fmi3Int32) NOT_OFFERED(fmi3Int64)
NOT_OFFERED(fmi3Int8) NOT_OFFERED(fmi3Reset) NOT_OFFERED(fmi3SerializeFMUState)
NOT_OFFERED(fmi3SerializedFMUStateSize) NOT_OFFERED(fmi3SetBinary) NOT_OFFERED(fmi3SetBoolean)
NOT_OFFERED(fmi3SetClock) NOT_OFFERED(fmi3SetContinuousStates) NOT_OFFERED(fmi3SetDebugLogging)
NOT_OFFERED(fmi3SetFMUState) NOT_OFFERED(fmi3SetFloat32) NOT_OFFERED(fmi3SetFloat64) NOT_OFFERED(fmi3SetInt16)
NOT_OFFERED(fmi3SetInt32) NOT_OFFERED(fmi3SetInt64) NOT_OFFERED(fmi3SetInt8) NOT_OFFERED(fmi3SetIntervalDecimal)
NOT_OFFERED(fmi3SetIntervalFraction) NOT_OFFERED(fmi3SetShiftDecimal) NOT_OFFERED(fmi3SetShiftFraction)
NOT_OFFERED(fmi3SetString) NOT_OFFERED(fmi3SetTime) NOT_OFFERED(fmi3SetUInt16) NOT_OFFERED(fmi3SetUInt32)
NOT_OFFERED(fmi3SetUInt64) NOT_OFFERED(fmi3SetUInt8) NOT_OFFERED(fmi3UInt16) NOT_OFFERED(fmi3UInt32)
NOT_OFFERED(fmi3UInt64) NOT_OFFERED(fmi3UInt8) NOT_OFFERED(fmi3UpdateDiscreteStates)
