"""The paper's boundary-value problem and its solution branches; shares no code with the discrete
rod."""
