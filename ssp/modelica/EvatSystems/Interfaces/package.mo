within EvatSystems;
package Interfaces "What an imported FMU has to look like"
end Interfaces;
