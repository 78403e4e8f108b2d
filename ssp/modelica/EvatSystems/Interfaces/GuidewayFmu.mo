within EvatSystems.Interfaces;
partial block GuidewayFmu "Connectors of EvatGuideway.fmu that the component uses"
  Modelica.Blocks.Interfaces.RealInput slip_velocity(unit = "m/s") "velocity of the slide";
  Modelica.Blocks.Interfaces.RealOutput friction_force(unit = "N") "friction force, against a positive slip where positive";
end GuidewayFmu;
