!> What to do instead of the words of FEAP that this program does not have. doc/manual/feap.md lists
!! them for users.
!!
!! Source: the manual of FEAPpv, and that of FEAP for words that decks use often; SPRIng is in
!!         neither, but is often tried.
module deck_feap
  use base_text, only: key_of
  implicit none
  private
  public :: mesh_hint, command_hint, property_hint

contains

  !> What to do instead of a word of FEAP of the mesh part; empty if the word is none of these.
  pure function mesh_hint(word) result(hint)
    character(*), intent(in) :: word
    character(:), allocatable :: hint

    select case (key_of(word))
    case ('angl', 'cang', 'ceul', 'eang', 'eule', 'tria')
      hint = 'nodes have no axes of their own; rotate the body so that its supports lie along ' &
             //'the axes (TRANsform, or ROTAte of PATCh)'
    case ('base', 'cbas', 'ebas')
      hint = 'MOVE prescribes the motion of supports'
    case ('blen', 'side', 'snod')
      hint = 'curved bodies are read by PATCh with FILE, by NPATch, or by MESH'
    case ('body')
      hint = 'BODY FORCe is a record of MATErial'
    case ('btem', 'temp')
      hint = 'there are no temperatures'
    case ('cdam', 'damp')
      hint = 'there are no dampers; TRANsient,HHT and TRANsient,BACK dissipate energy'
    case ('cmas', 'mpro')
      hint = 'there are no point masses; DENSity of MATErial gives the mass'
    case ('coun')
      hint = 'nodes and elements are counted automatically; remove this word'
    case ('cpro')
      hint = 'EPROportional and FPROportional choose the load table of a node'
    case ('csti', 'spri', 'stif')
      hint = 'there are no springs; use elements with a small modulus'
    case ('debu')
      hint = 'every deck is checked; remove this word'
    case ('elin', 'link', 'slav')
      hint = 'TIE joins nodes at the same position, and CONStraint of MESH ties a node to others'
    case ('ereg', 'regi')
      hint = 'there are no regions; give each body its own PATCh, or its own material'
    case ('flex')
      hint = 'every body is flexible, except a PATCh of TYPE RIGId'
    case ('foll')
      hint = 'PRESsure with FOLLower follows the surface'
    case ('glob')
      hint = 'the control record gives ndm and ndf, and MATErial the type of strains'
    case ('join')
      hint = 'TIE joins nodes at the same position; there are no other joints'
    case ('lfor')
      hint = 'FORCe, EFORce and CFORce load nodes, and PRESsure loads faces'
    case ('load')
      hint = 'FORCe, EFORce and CFORce load nodes, and PRESsure loads faces; PROP defines how ' &
             //'loads vary in time'
    case ('manu')
      hint = 'there is no interactive input; remove this word'
    case ('mass')
      hint = 'there are no point masses; DENSity of MATErial gives the mass, and MASS is a ' &
             //'command between BATCh and END'
    case ('moda')
      hint = 'there are no modes; a body is either elastic or a PATCh of TYPE RIGId'
    case ('nblo', 'nsid')
      hint = 'NPATch takes the control points of a whole solid'
    case ('nopa', 'pars')
      hint = 'expressions are always evaluated; remove this word'
    case ('orde')
      hint = 'METIS orders the equations; remove this word'
    case ('peri')
      hint = 'CONStraint of MESH ties a node to others; there are no other periodic conditions'
    case ('pola')
      hint = 'COORdinates take expressions, such as r*cosd(30); TRANsform rotates and shifts nodes'
    case ('reac')
      hint = 'FORCe loads nodes; REAC is a command between BATCh and END'
    case ('read')
      hint = 'INCLude reads another file'
    case ('rese')
      hint = 'restraints cannot be removed; give each of them only where it is needed'
    case ('rigi')
      hint = 'a rigid body is a PATCh of TYPE RIGId'
    case ('rota')
      hint = 'ROTAte is a record of PATCh, MESH and SPLIne; TRANsform rotates nodes'
    case ('save')
      hint = 'records of the mesh cannot be saved; INCLude reads them from a file, and SAVE is a ' &
             //'command between BATCh and END'
    case ('sblo')
      hint = 'BLOCk makes 8-node elements in a mapped region'
    case ('shif')
      hint = 'TRANslate of PATCh and MESH shifts a body, and TRANsform shifts nodes'
    case ('sloa')
      hint = 'PRESsure loads faces of bodies, and CSURface a surface that is given by points'
    case ('sphe')
      hint = 'COORdinates take expressions, such as r*cosd(30); HEMIsphere of PATCh is half of ' &
             //'a hollow sphere'
    case ('spin')
      hint = 'there are no centrifugal forces: BODY FORCe of MATErial is constant; MOVE with ' &
             //'ROTAte turns a body'
    case ('swee')
      hint = 'MOVE with ROTAte prescribes a rotation'
    case ('titl')
      hint = 'the title follows FEAP in the first record; remove this word'
    case default
      hint = ''
    end select
    if (hint /= '') hint = 'not available here: '//hint
  end function mesh_hint

  !> What to do instead of a word of FEAP of the solution part; empty if the word is none of these.
  pure function command_hint(word) result(hint)
    character(*), intent(in) :: word
    character(:), allocatable :: hint

    select case (key_of(word))
    case ('acce')
      hint = 'accelerations are not printed; DISP prints displacements'
    case ('acti', 'deac')
      hint = 'parts of a body cannot be added or removed'
    case ('back')
      hint = 'AUTO repeats a failed step in smaller steps'
    case ('base')
      hint = 'MOVE prescribes the motion of supports'
    case ('beta')
      hint = 'TRANsient chooses the scheme of time integration'
    case ('bfgs')
      hint = 'UTAN,LINE,1 searches along the increment; FACTor REUSe solves with an earlier tangent'
    case ('chec')
      hint = 'every deck is checked before it is solved; bezel --check only checks it'
    case ('comm')
      hint = '! starts a comment'
    case ('cont')
      hint = 'contact is searched in each iteration; remove this word'
    case ('damp')
      hint = 'there is no damping matrix; TRANsient,HHT and TRANsient,BACK dissipate energy'
    case ('data')
      hint = 'write the values of DT and TOL in these commands; INCLude reads another file'
    case ('debu', 'echo', 'show')
      hint = 'the log lists what was read and done; remove this word'
    case ('dire', 'iter', 'meth')
      hint = 'FACTor chooses how linear systems are solved'
    case ('eige', 'eigv', 'subs')
      hint = 'there are no eigenvalues; the report counts the negative pivots of the tangent'
    case ('else', 'endi', 'if  ')
      hint = 'there are no conditions; a loop of Newton''s iteration ends when it has converged'
    case ('erro')
      hint = 'errors are not estimated; compare two meshes'
    case ('expl')
      hint = 'time integration is implicit: TRANsient,BACK, TRANsient,NEWMark or TRANsient,HHT'
    case ('geom')
      hint = 'TANG includes the geometric stiffness of FINIte strains; remove this word'
    case ('hist', 'manu')
      hint = 'there is no interactive input; remove this word'
    case ('iden')
      hint = 'there are no eigenvalues; remove this word'
    case ('init')
      hint = 'bodies start at rest, with zero displacements'
    case ('jint')
      hint = 'there are no J integrals; COHEsive of CONTact gives bonds a fracture energy'
    case ('line')
      hint = 'the law of MATErial decides; ELAStic ISOTropic is linear'
    case ('list')
      hint = 'CURVe names the quantities of a table'
    case ('mesh')
      hint = 'the mesh cannot change during the solution; PROP, MOVE and DISPlacement change ' &
             //'loads and motions'
    case ('moda')
      hint = 'there are no modes; TRANsient integrates in time'
    case ('newf')
      hint = 'give a separate load table to loads that must remain: PROP, FPROportional ' &
             //'and EPROportional'
    case ('nonl')
      hint = 'the law of MATErial decides; ELAStic NEOHook is nonlinear'
    case ('ntan')
      hint = 'TANG and UTAN form the tangent of all elements'
    case ('outm')
      hint = 'the result file contains the mesh, and the log lists what was read'
    case ('paus')
      hint = 'a run never waits for input; remove this word'
    case ('quit')
      hint = 'END closes the commands, and STOP the deck'
    case ('read')
      hint = 'RESTart continues from a checkpoint; INCLude reads another file'
    case ('renu')
      hint = 'METIS orders the equations; remove this word'
    case ('resi')
      hint = 'FORM forms the residual'
    case ('scre')
      hint = 'bezel --quiet shows less on the screen'
    case ('tie ')
      hint = 'TIE belongs before BATCh'
    case ('velo')
      hint = 'velocities are not printed; DISP prints displacements'
    case ('writ')
      hint = 'PLOT and OUTPut write fields, and SAVE writes a checkpoint'
    case ('zero')
      hint = 'write a separate deck for another analysis'
    case default
      hint = ''
    end select
    if (hint /= '') hint = 'not available here: '//hint
  end function command_hint

  !> What to do instead of a record that FEAP has in MATErial; empty if the word is none of these.
  pure function property_hint(word) result(hint)
    character(*), intent(in) :: word
    character(:), allocatable :: hint

    select case (key_of(word))
    case ('angl')
      hint = 'materials are isotropic and have no axes'
    case ('axis', 'plan')
      hint = 'models are three-dimensional (ndm = 3)'
    case ('cree', 'plas', 'visc')
      hint = 'the only laws are ELAStic ISOTropic and ELAStic NEOHook'
    case ('damp')
      hint = 'there is no damping; TRANsient,HHT and TRANsient,BACK dissipate energy'
    case ('four', 'ther')
      hint = 'there are no temperatures'
    case ('geom')
      hint = 'FINIte strains include the geometric stiffness; remove this record'
    case ('mass')
      hint = 'MASS is a command between BATCh and END; DENSity gives the mass'
    case ('mixe')
      hint = 'ENHAnced elements do not lock'
    case ('nonl')
      hint = 'FINIte, with ELAStic NEOHook, is for large deformations'
    case ('pres')
      hint = 'PRESsure is a word of the mesh, outside of MATErial'
    case ('quad')
      hint = 'QUADrature is a record of PATCh'
    case default
      hint = ''
    end select
    if (hint /= '') hint = 'not available here: '//hint
  end function property_hint

end module deck_feap
