within EvatSystems.Examples;
partial model StickSlip "A mass pulled by a spring at constant speed; extend it and redeclare Contact"
  replaceable block Contact = EvatSystems.Interfaces.GuidewayFmu constrainedby EvatSystems.Interfaces.GuidewayFmu "Redeclare by the imported FMU";
  Modelica.Mechanics.Translational.Sources.ConstantSpeed pull(v_fixed = 0.1);
  Modelica.Mechanics.Translational.Components.Spring spring(c = 2);
  Modelica.Mechanics.Translational.Components.Mass mass(m = 1, s(fixed = true, start = 0), v(fixed = true, start = 0));
  EvatSystems.GuidewayFriction friction(redeclare Contact contact);
  Modelica.Mechanics.Translational.Components.Fixed ground;
equation
  connect(pull.flange, spring.flange_b);
  connect(spring.flange_a, mass.flange_a);
  connect(mass.flange_b, friction.flange_b);
  connect(friction.flange_a, ground.flange);
  annotation(experiment(StopTime = 28, Tolerance = 1e-8));
end StickSlip;
