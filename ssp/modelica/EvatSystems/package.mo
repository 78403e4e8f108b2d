within ;
package EvatSystems "The contact of EVAT between mechanical connectors, for tools that import FMUs"
  annotation(
    version = "0.2.0",
    uses(Modelica(version = "4.0.0")),
    Documentation(info = "<html>
<p>Import <code>EvatTurning-fmi2.fmu</code> and <code>EvatGuideway-fmi2.fmu</code> (written by <code>evat build</code>) with the tool's own
command, for co-simulation or model exchange, and redeclare the replaceable block of the components here by the imported one. Its connectors
have the names of the FMU's variables, so that nothing else is to be done.</p>
</html>"));
end EvatSystems;
