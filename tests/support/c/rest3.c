/* The functions of FMI 3.0 that clocks3.c does not have and a library must have: they fail. */
#define NONE(Name) \
    __attribute__((visibility("default"))) int fmi3##Name(void) { return 3; }
NONE(ActivateModelPartition) NONE(EnterConfigurationMode) NONE(EvaluateDiscreteStates) NONE(ExitConfigurationMode)
NONE(GetAdjointDerivative) NONE(GetBoolean) NONE(GetDirectionalDerivative) NONE(GetFloat32) NONE(GetInt16)
NONE(GetInt64) NONE(GetInt8) NONE(GetIntervalFraction) NONE(GetNumberOfVariableDependencies) NONE(GetOutputDerivatives)
NONE(GetShiftFraction) NONE(GetString) NONE(GetUInt16) NONE(GetUInt32) NONE(GetUInt64)
NONE(GetUInt8) NONE(GetVariableDependencies) NONE(GetVersion) NONE(InstantiateScheduledExecution) 
NONE(SetBoolean) NONE(SetDebugLogging) NONE(SetFloat32) NONE(SetInt16) NONE(SetInt64) NONE(SetInt8)
NONE(SetIntervalFraction) NONE(SetShiftDecimal) NONE(SetShiftFraction) NONE(SetString)
NONE(SetUInt16) NONE(SetUInt32) NONE(SetUInt64) NONE(SetUInt8)
